"""The settings of a run as TOML, which --config reads and each run writes."""

import argparse
import re
import sys

from ..errors import InputError
from ..nearnames import didYouMean
from .savedrun import SavedRun

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

# Options of how a run is started and reported, which do not belong to its settings.
_NOT_SETTINGS = ("help", "config", "resume", "overwrite", "verbose", "scheduler")

_TABLE = "sample"

_LARGEST_FILE = 10**6  # bytes

# Reading nested keys takes time quadratic in their number.
_DEEP_KEY = re.compile(r"""(?<![\w-])(?:(?:[\w-]+|"[^"\n]*"|'[^'\n]*')[ \t]*\.[ \t]*){32}""")
_TOO_DEEP = "is not TOML of settings (lists or tables within each other are too deep: a setting is a value or a list)"


def addConfig(parser):
    """Add the option that reads settings."""
    parser.add_argument(
        "--config",
        metavar="FILE",
        help="read settings from a TOML file, such as the one that each run writes; other options take precedence",
    )


def applySettings(parser, arguments):
    """Use the settings of --config or --resume, if among the arguments, as the parser's defaults.

    Raises
    ------
    InputError
        if the file cannot be read, or contains an unknown setting or a wrong value
    """
    # The base class's method, so that values that look like options are not parsed as options.
    given, _ = argparse.ArgumentParser.parse_known_args(parser, arguments)
    if given.config is not None and given.resume is not None:
        raise InputError("--config and --resume cannot be used together: a resumed run keeps its settings")
    if given.config is not None:
        settings, source = readSettings(given.config), given.config
    elif given.resume is not None:
        settings, source = SavedRun(given.resume).settings, given.resume
        paths = [name for name in ("json", "notes", "report") if name in settings and getattr(given, name) is None]
        parser.set_defaults(pathsOfRun=paths)  # from the run, not from the user who resumes it
        if given.scheduler is not None:
            settings.pop("workers", None)  # the number for this machine
    else:
        return
    actions = _settingsOf(parser)
    for name, value in settings.items():
        if name not in actions:
            raise InputError(f"{source}: {name} is not a setting of this command{didYouMean(name, actions)}")
        action = actions[name]
        parser.set_defaults(**{action.dest: _read(parser, action, value, f"{source}: {name}")})


def _read(parser, action, value, name):
    """Return the value of an option from a TOML value, which is never parsed as an argument."""
    if action.nargs == 0:
        if not isinstance(value, bool):
            raise InputError(f"{name} must be true or false")
        return value
    if isinstance(value, bool):
        raise InputError(f"{name} must be a value, not true or false")
    values = value if isinstance(value, list) else [value]
    if not values or not all(isinstance(item, (str, int, float)) and not isinstance(item, bool) for item in values):
        raise InputError(f"{name} must be a text, a number or a list of these")
    if any("\0" in str(item) for item in values):
        raise InputError(f"{name} has a character that no argument may have, NUL")
    texts = [item if isinstance(item, str) else repr(item) for item in values]
    try:
        if action.nargs == "+":
            return [_readOne(parser, action, text) for text in texts]
        return _readOne(parser, action, ",".join(texts))
    except argparse.ArgumentError as error:
        raise InputError(f"{name}: {error.message}") from error


def _readOne(parser, action, text):
    value = parser._get_value(action, text)
    parser._check_value(action, value)
    return value


def readSettings(path):
    """Return the settings of a TOML file as a dictionary.

    Raises
    ------
    InputError
        if it cannot be read, or has no settings
    """
    try:
        with open(path, "rb") as file:
            data = file.read(_LARGEST_FILE + 1)
        if len(data) > _LARGEST_FILE:
            raise InputError(f"{path}: settings take at most {_LARGEST_FILE:,} bytes")
        text = data.decode("utf-8")
        if _DEEP_KEY.search(text):
            raise InputError(f"{path}: {_TOO_DEEP}")
        content = tomllib.loads(text)
    except OSError as error:
        raise InputError(f"{path}: cannot be read ({error.strerror or error})") from error
    except RecursionError as error:
        raise InputError(f"{path}: {_TOO_DEEP}") from error
    except ValueError as error:  # from TOML, bytes that are not text, or numbers with thousands of digits
        raise InputError(f"{path}: is not TOML ({error})") from error
    others = [name for name in content if name != _TABLE]
    if others or not isinstance(content.get(_TABLE), dict):
        raise InputError(
            f"{path}: settings stand in one table [{_TABLE}]" + (f", but there is {others[0]}" if others else "")
        )
    return content[_TABLE]


def settingsOf(parser, options):
    """Return the settings among the options of a run as a dictionary, without options that are not given.

    Raises
    ------
    InputError
        if one cannot be written as TOML: a name that is not text
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
    """Refuse a file name whose bytes are not text, which Python strings can hold."""
    try:
        str(value).encode("utf-8")
    except UnicodeEncodeError as error:
        encoding = sys.getfilesystemencoding()
        raise InputError(f"{name} {value!r}: settings cannot hold it, since it is not text in {encoding}") from error


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
