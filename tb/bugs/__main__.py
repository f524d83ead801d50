"""``python -m tb.bugs LIST``: which tests notice the bugs of a list, see `tb.bugs.injection`."""

from tb.bugs.injection import main

if __name__ == "__main__":
    main()
