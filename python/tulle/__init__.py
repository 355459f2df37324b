"""Tulle: a cloth simulator that never lets cloth pass through anything.

>>> import tulle
>>> world = tulle.World()
>>> cloth = world.add_cloth(tulle.make_shape("rectangle", resolution=20).transform(translation=(0, 0, 0.5)))
>>> ball = world.add_obstacle(tulle.make_shape("sphere", radius=0.3))
>>> for _ in range(90):
...     report = world.step(1 / 90)

All quantities are in SI units: metres, kilograms, seconds, radians. docs/guide/python.md says more.
"""
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from tulle._names import *  # noqa: F403
else:
    # The libraries are loaded when a name is asked for: `python -m tulle.sweep` needs none of them.
    def __getattr__(name):
        if name.startswith("__") and name not in ("__all__", "__version__"):
            raise AttributeError(name)
        import importlib.util
        if importlib.util.find_spec(f"tulle.{name}"):
            return importlib.import_module(f"tulle.{name}")
        _names = importlib.import_module("tulle._names")
        public = {key: value for key, value in vars(_names).items() if not key.startswith("_")}
        globals().update(public, __all__=sorted(public), __version__=_names.__version__)
        if name not in globals():
            raise AttributeError(f"module 'tulle' has no attribute '{name}'")
        return globals()[name]

    def __dir__():
        return sorted({*globals(), *__getattr__("__all__")})
