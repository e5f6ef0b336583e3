"""Two-body verification problem: by hand, by the engine and as printed.

S. Frimpong and M. Thiruvengadam, "Multi-Body Dynamic Modeling and Simulation of Crawler-Formation
Interactions in Surface Mining Operations - Crawler Kinematics" (K-paper), tables 7 and 8.
"""

import typer

from exudyn_crawler.parameters import ContactLaw
from exudyn_crawler.tables import print_table
from exudyn_crawler.verification import (
    compare_verification,
    compare_with_paper,
    engine_solution,
    hand_solution,
)


def main() -> None:
    """Solve the two-body problem by hand and by the engine, side by side.

    Example: python -m studies.verification
    """
    law = ContactLaw.oil_sand()
    engine = engine_solution(law)
    print_table(compare_verification(hand_solution(law), engine), "Two-body problem at t = 0.5 s")
    print_table(compare_with_paper(engine), "Paper against computed")


if __name__ == "__main__":
    typer.run(main)
