"""Errors of arguments and files, which know whose they are."""

from contextlib import contextmanager


class InputError(ValueError):
    """A wrong argument or file: one sentence that begins with its name.

    The attributes are the parameters: the `predicate`, which is the sentence behind the name; the
    `argument`, or a tuple of them; the `path` of a file; and the `name`, by default the file or the
    arguments in backticks.
    """

    def __init__(self, predicate, *, argument="", path="", name=""):
        self.predicate, self.argument, self.path = predicate, argument, str(path)
        names = [path] if path else [argument] if isinstance(argument, str) else argument
        self.name = name or " and ".join(f"`{name}`" for name in names if name)
        blank = " " if self.name and predicate[:1] not in (",", ":") else ""
        super().__init__(f"{self.name}{blank}{predicate}")

    def renamed(self, names):
        """A copy of the error, which begins as a dict says by argument."""
        name = names.get(self.argument, self.name)
        return InputError(self.predicate, argument=self.argument, path=self.path, name=name)


@contextmanager
def of_file(path):
    """A block in which a file is read or written: an InputError without a name gets its path."""
    try:
        yield
    except UnicodeDecodeError as error:
        byte = error.object[error.start]
        raise InputError(
            f"is not UTF-8 text: its byte {error.start} is {byte}", path=path
        ) from None
    except InputError as error:
        if error.name:
            raise
        raise InputError(error.predicate, path=path) from error
