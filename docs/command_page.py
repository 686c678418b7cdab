"""Writes docs/reference/made/command.md from the parsers of the command; the build calls it."""

from __future__ import annotations

import argparse
import os

HEAD = """# The command vtk-mls

The text of `vtk-mls COMMAND --help`.
"""


def write(docs):
    """Write the page into the folder of the documentation."""
    folder = docs / "reference" / "made"
    folder.mkdir(exist_ok=True)
    (folder / "command.md").write_text(page(), encoding="utf-8")


def page():
    """The text of the page."""
    from vtk_mls.commands import cli

    os.environ["COLUMNS"] = "78"
    commands = next(
        action
        for action in cli._parser()._actions
        if isinstance(action, argparse._SubParsersAction)
    )
    helps = {action.dest: action.help for action in commands._choices_actions}
    seen, parts = [], [HEAD]
    for name, parser in commands.choices.items():
        if parser not in seen:  # an alias has its parser
            seen.append(parser)
            parts.append(_command(name, parser, helps))
    return "\n".join(parts)


def _command(name, parser, helps):
    usage = parser.format_usage().removeprefix("usage: ")
    about = _sentence(parser.description or helps.get(name, ""))
    parts = [f"## vtk-mls {name}\n\n{about}\n\n```text\n{usage}```\n"]
    for group in parser._action_groups:
        actions = [action for action in group._group_actions if action.help != argparse.SUPPRESS]
        if actions:
            parts.append(f"*{group.title.capitalize()}*\n")
            parts += [_action(action, parser) for action in actions]
    if parser.epilog:
        parts.append(f"```text\n{parser.epilog}\n```\n")
    return "\n".join(parts)


def _action(action, parser):
    formatter = parser._get_formatter()
    if action.option_strings:
        name = formatter._format_action_invocation(action)
    else:
        name = action.metavar or action.dest
    said = formatter._expand_help(action) if action.help else ""
    return f"`` {name} ``\n: {_sentence(said)}\n"


def _sentence(text):
    """Text as Markdown: what has a meaning there is escaped."""
    text = " ".join(text.split())
    for mark in "\\*_<>[]":
        text = text.replace(mark, f"\\{mark}")
    return text or "-"
