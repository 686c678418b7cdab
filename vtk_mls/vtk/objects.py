"""Settings and copies of VTK and ITK objects, and the output of an algorithm."""


def configured(thing, **values):
    """A VTK or ITK object after `SetName(value)` for each keyword `Name`."""
    for name, value in values.items():
        getattr(thing, f"Set{name}")(value)
    return thing


def output_of(algorithm, **values):
    """The output of an algorithm that is `configured` and updated."""
    configured(algorithm, **values).Update()
    return algorithm.GetOutput()


def shallow_copy(thing):
    """A copy of a VTK object that shares its arrays, of the same class."""
    copy = thing.NewInstance()
    copy.ShallowCopy(thing)
    return copy
