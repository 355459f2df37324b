"""Runs the tests of the add-on in Blender: blender -b --factory-startup --python blender/tests/run.py -- [TEST...]

TULLE names the program. Exit code 0: all passed.
"""
import os
import sys
import unittest

HERE = os.path.dirname(os.path.abspath(__file__))
sys.path[:0] = [HERE, os.path.dirname(HERE)]
sys.dont_write_bytecode = True

names = sys.argv[sys.argv.index("--") + 1 :] if "--" in sys.argv else []
loader = unittest.defaultTestLoader
suite = loader.loadTestsFromNames(names) if names else loader.discover(HERE, "test_*.py")
result = unittest.TextTestRunner(verbosity=2, stream=sys.stdout).run(suite)
sys.stdout.flush()
os._exit(0 if result.wasSuccessful() and result.testsRun > 0 else 1)
