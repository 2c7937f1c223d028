"""Build, validate and pack the FMUs: python build_fmu.py [--output dist] [MODEL ...]."""

from fmu_src.build.command import main

if __name__ == "__main__":
    main()
