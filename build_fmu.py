"""Build, validate and pack the FMUs: python build_fmu.py [--output dist] [MODEL ...]."""

import sys

from fmu_src.errors import BuildError

OURS = ("fmu_src", "models")


def run() -> None:
    """Build, or say in a sentence which package this Python lacks, or which FMU has no interface table."""
    try:
        from fmu_src.build.command import main
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if not package or package in OURS:
            raise
        sys.exit(f'error: building FMUs needs the package {package}; pip install -e ".[build]" brings all it needs')
    except BuildError as error:
        sys.exit(f"error: {error}")
    main()


if __name__ == "__main__":
    run()
