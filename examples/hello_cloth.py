"""hello_cloth - a square metre of cotton falls on a ball; ends with a report and the judge's verdict."""
import sys

import tulle

world = tulle.World()
sheet = tulle.make_shape("rectangle", size=(1, 1), resolution=31).transform(translation=(0, 0, 0.35))
cloth = world.add_cloth(sheet, material="cotton")
ball = world.add_obstacle(tulle.make_shape("sphere", radius=0.3))

for _ in range(60):
    report = world.step(1 / 90)
print(f"{report.time:.3f} s: {report.contacts} contacts, smallest gap {1e3 * report.smallest_gap:.3g} mm, "
      f"greatest stretch {report.max_stretch:.3f}")

verdict = tulle.Judge().find_intersections([cloth.mesh], [ball.mesh])
print(f"{len(verdict.pairs)} intersections")
sys.exit(not verdict.is_clean)
