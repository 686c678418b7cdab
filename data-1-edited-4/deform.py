"""Makes the deformed data that were edited with `vtk-mls view` again.

In a shell:

    vtk-mls deform data-1.vtp handles.csv data-1-deformed.vtp
"""

from pathlib import Path

from vtk_mls import io
from vtk_mls.filters import MLSDeform

here = Path(__file__).parent
deform = MLSDeform()
deform.SetInputData(1, io.read_control_points(here / "handles.csv"))

for source, target in [("data-1.vtp", "data-1-deformed.vtp")]:
    deform.SetInputData(0, io.read_dataset(here / source))
    deform.Update()
    io.write_dataset(deform.GetOutput(), here / target)
    print(here / target)
