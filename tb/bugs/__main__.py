"""``python -m tb.bugs``: which tests notice drawn bugs, see `tb.bugs.command`."""

from tb.bugs.command import main

if __name__ == "__main__":
    main()
