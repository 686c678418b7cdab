"""`python -m vtk_mls`."""

import sys

try:
    from vtk_mls.commands.cli import main

    status = main()
except KeyboardInterrupt:
    status = 130
sys.exit(status)
