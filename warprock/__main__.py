"""`python -m warprock`."""

from warprock.cli import main

if __name__ == "__main__":
    main()
