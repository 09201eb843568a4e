"""`python -m warprock`."""

from warprock.cli import entry

if __name__ == "__main__":
    entry()
