"""`python -m warprock`."""

from warprock.cli.main import entry

if __name__ == "__main__":
    entry()
