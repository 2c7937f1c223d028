"""Build, validate and pack the FMUs: python build_fmu.py [--output dist] [MODEL ...]."""

import sys

OURS = ("fmu_src", "models")


def run() -> None:
    """Build, or say in a sentence which package that needs and this Python does not have."""
    try:
        from fmu_src.build.command import main
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if not package or package in OURS:
            raise
        sys.exit(f'error: building FMUs needs the package {package}; pip install -e ".[build]" brings all it needs')
    main()


if __name__ == "__main__":
    run()
