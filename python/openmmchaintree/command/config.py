"""The settings of a run as TOML: read by --config, written by each run."""

import argparse
import sys

from ..errors import InputError
from .replicarun import SavedRun

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

# What says how a run is told, not what it does.
_NOT_SETTINGS = ("help", "config", "resume", "overwrite", "verbose", "scheduler")

_TABLE = "sample"


def addConfig(parser):
    """Add the option that reads settings."""
    parser.add_argument(
        "--config",
        metavar="FILE",
        help="read settings from a TOML file, such as the one that each run writes; options given beside it come first",
    )


def expandArguments(parser, arguments):
    """Return arguments of the command, before them what a --config or --resume among them stands for.

    Raises
    ------
    InputError
        if its file cannot be read, or has what is no setting
    """
    finder = argparse.ArgumentParser(add_help=False, allow_abbrev=False, exit_on_error=False)
    finder.add_argument("--config")
    finder.add_argument("--resume")
    finder.add_argument("--scheduler")
    try:
        found, _ = finder.parse_known_args(arguments)
    except argparse.ArgumentError:
        return arguments  # the parser itself will say so
    if found.config is not None and found.resume is not None:
        raise InputError("--config and --resume cannot be used together: a run goes on with its own settings")
    if found.config is not None:
        return _withSettings(parser, readSettings(found.config), ["--config", found.config], arguments)
    if found.resume is not None:
        settings = SavedRun(found.resume).settings
        if found.scheduler is not None:
            settings.pop("workers", None)  # those of this machine
        return _withSettings(parser, settings, ["--resume", found.resume], arguments)
    return arguments


def _withSettings(parser, settings, source, arguments):
    """Return arguments of the command with settings before them, which they overrule. source: their option and file."""
    given, _ = argparse.ArgumentParser.parse_known_args(parser, arguments)
    begin, others = [], []
    for name, value in settings.items():
        action = _settingsOf(parser).get(name)
        if action is None:
            raise InputError(f"{source[1]}: {name} is no setting of this command")
        texts = _asTexts(action, value, f"{source[1]}: {name}")
        if not action.option_strings:
            begin += texts if getattr(given, action.dest) is None else []
        elif action.nargs == 0:
            others += [f"--{name}"] if value else []
        elif action.nargs is None:
            others += [f"--{name}={','.join(texts)}"]
        else:
            others += [f"--{name}", *texts]
    # The file's name once more ends a list of values before what was given.
    return [*begin, *others, *source, *arguments]


def _asTexts(action, value, name):
    """Return a value of TOML as texts."""
    if (action.nargs == 0) != isinstance(value, bool):
        raise InputError(f"{name} must be {'true or false' if action.nargs == 0 else 'a value, not true or false'}")
    values = value if isinstance(value, list) else [value]
    if not values or not all(isinstance(item, (str, int, float)) for item in values):
        raise InputError(f"{name} must be a text, a number or a list of these")
    if any("\0" in str(item) for item in values):
        raise InputError(f"{name} has a character that no argument may have, NUL")
    return [item if isinstance(item, str) else repr(item) for item in values]


def readSettings(path):
    """Return the settings of a TOML file as a dictionary.

    Raises
    ------
    InputError
        if it cannot be read, or has no settings
    """
    try:
        with open(path, "rb") as file:
            content = tomllib.load(file)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from error
    except (tomllib.TOMLDecodeError, UnicodeDecodeError) as error:
        raise InputError(f"{path}: is no TOML ({error})") from error
    others = [name for name in content if name != _TABLE]
    if others or not isinstance(content.get(_TABLE), dict):
        raise InputError(
            f"{path}: settings stand in one table [{_TABLE}]" + (f", but there is {others[0]}" if others else "")
        )
    return content[_TABLE]


def settingsOf(parser, options):
    """Return the settings among the options of a run as a dictionary; options that are not given stay out.

    Raises
    ------
    InputError
        if one cannot be written as TOML: a name that is no text
    """
    settings = {name: getattr(options, action.dest) for name, action in _settingsOf(parser).items()}
    for name, value in settings.items():
        for text in value if isinstance(value, (list, tuple)) else [value]:
            _checkText(name, text)
    return {
        name: list(value) if isinstance(value, tuple) else value
        for name, value in settings.items()
        if value is not None and value is not False and value != () and value != []
    }


def _checkText(name, value):
    """Refuse a name of a file whose bytes are no text, which Python holds all the same."""
    try:
        str(value).encode("utf-8")
    except UnicodeEncodeError as error:
        encoding = sys.getfilesystemencoding()
        raise InputError(f"{name} {value!r}: is no text in {encoding}, so that settings cannot hold it") from error


def asTOML(settings):
    """Return settings as the text of a file."""
    import tomli_w

    return tomli_w.dumps({_TABLE: settings})


def _settingsOf(parser):
    """Return the actions of a parser that are settings, by their names in the file."""
    actions = {}
    for action in parser._actions:
        name = action.option_strings[-1].removeprefix("--") if action.option_strings else action.dest
        if name not in _NOT_SETTINGS:
            actions[name] = action
    return actions
