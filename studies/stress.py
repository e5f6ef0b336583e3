"""Stresses of the flexible shoes of the P&H 4100C track over propel and a loading cycle.

Reproduces the figures and tables of S. Frimpong and M. Thiruvengadam, "Multibody Dynamic Stress Simulation
of Rigid-Flexible Shovel Crawler Shoes", Minerals 2016, 6(3), 61 (S-paper).
"""

from exudyn_crawler.cli import run_script, stress

if __name__ == "__main__":
    run_script(stress)
