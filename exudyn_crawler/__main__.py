"""``python -m exudyn_crawler`` is the command `exudyn-crawler`."""

from exudyn_crawler.cli import main

if __name__ == "__main__":
    main()
