"""Kinematics of the P&H 4100C crawler track on oil sand, straight and turning.

Reproduces the figures and tables of S. Frimpong and M. Thiruvengadam, "Multi-Body Kinematics Simulation
Modeling and Analysis of Shovel Crawler Performance in Rugged Surface Mining Terrains" (K-chapter) and
"Multi-Body Dynamic Modeling and Simulation of Crawler-Formation Interactions in Surface Mining
Operations - Crawler Kinematics" (K-paper).
"""

from exudyn_crawler.cli import kinematics, run_script

if __name__ == "__main__":
    run_script(kinematics)
