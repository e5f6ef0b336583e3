"""The crawler track on ground whose units have different heights: a step, a ramp, a random roughness.

The papers' ground is even and their contact law presumes it; here the second contact model runs, with
spheres under the shoes (docs/general_contact.md).
"""

from exudyn_crawler.cli import run_script, uneven

if __name__ == "__main__":
    run_script(uneven)
