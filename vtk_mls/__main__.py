"""`python -m vtk_mls`."""

import sys

from vtk_mls.cli import main

sys.exit(main())
