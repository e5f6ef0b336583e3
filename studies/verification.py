"""Two-body verification problem: by hand, by the engine and as printed.

S. Frimpong and M. Thiruvengadam, "Multi-Body Dynamic Modeling and Simulation of Crawler-Formation
Interactions in Surface Mining Operations - Crawler Kinematics" (K-paper), tables 7 and 8.
"""

from exudyn_crawler.cli import run_script, verify

if __name__ == "__main__":
    run_script(verify)
