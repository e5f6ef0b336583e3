"""Contact, friction and joint forces, sinkage and terrain deformation of the P&H 4100C track.

Reproduces the figures and tables of S. Frimpong and M. Thiruvengadam, "Contact and Joint Forces Modeling
and Simulation of Crawler-formation Interactions" (F-paper).
"""

from exudyn_crawler.cli import forces, run_script

if __name__ == "__main__":
    run_script(forces)
