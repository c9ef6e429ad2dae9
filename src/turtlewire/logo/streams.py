"""The files of a program: those that are open, the one it reads, the one it writes, and the dribble file."""

from __future__ import annotations

from turtlewire.logo.errors import LogoError
from turtlewire.logo.keyboard import Keyboard, StandardInput
from turtlewire.logo.open_file import Buffer, OpenFile, cannot_open, decode
from turtlewire.logo.values import NIL, make_list, spelled

TYPE_CHECKING = False
if TYPE_CHECKING:
    from collections.abc import Callable
    from pathlib import Path

    from turtlewire.logo.evaluator import Interpreter
    from turtlewire.logo.values import List, Value

_ALREADY_DRIBBLING = 17
_ALREADY_OPEN = 41
_NOT_OPEN = 42


def not_open(name: str, hint: str) -> LogoError:
    """A file that must be open first."""
    return LogoError(_NOT_OPEN, f"File {name or '||'} not open", hint=hint)


class Streams:
    """The open files of one interpreter; its ``write`` goes to the file that SETWRITE set.

    Attributes:
        keyboard: what is read when no file is.
        prefix: the folder that file names are taken from; ``""`` for none.
        reader: the name of the file that is read, ``None`` for the keyboard.
        writer: the name of the file that is written or the list of a buffer, ``None`` for the screen.
        latest: the file that was loaded or saved last.
    """

    def __init__(self, logo: Interpreter) -> None:
        self.keyboard: Keyboard = StandardInput()
        self.prefix = ""
        self.reader: str | None = None
        self.writer: str | List | None = None
        self.latest = ""
        self._logo = logo
        self._files: dict[str, OpenFile] = {}
        self._buffers: list[Buffer] = []
        self._dribble: OpenFile | None = None
        self._screen: Callable[[str], object] = logo.write
        self._diverted: Callable[[str], object] = self._write

    # --- opening and closing ----------------------------------------------------------------------------------

    def path(self, name: str) -> Path:
        """Where a file of this name is."""
        from pathlib import Path  # takes as long to load as all of Logo's primitives

        return Path(self.prefix, name) if self.prefix else Path(name)

    def open(self, name: str, mode: str) -> None:
        """Open a file.

        Raises:
            LogoError: it is open, or cannot be opened.
        """
        if name in self._files:
            raise LogoError(
                _ALREADY_OPEN, f"File {name} already open", hint=f'Close it first: close "{spelled(name)}'
            )
        if not name:
            raise cannot_open(name, OSError(0, "a file has a name"), self.path(name))
        self._files[name] = OpenFile(name, self.path(name), mode)

    def open_buffer(self, target: List, size: int, *, is_implicit: bool = False) -> None:
        """Open a buffer for a list, which is not a copy of one that has one."""
        if self._buffer(target) is not None:
            raise LogoError(_ALREADY_OPEN, "File already open", hint="There is a buffer for this list.")
        self._buffers.append(Buffer(target, size, is_implicit=is_implicit))

    def _buffer(self, target: List) -> Buffer | None:
        return next((each for each in self._buffers if each.target is target), None)

    def has_buffer(self, target: List) -> bool:
        """Whether this very list has a buffer."""
        return self._buffer(target) is not None

    @property
    def names(self) -> List:
        """What is open, the newest first."""
        buffers = [each.target for each in reversed(self._buffers)]
        return make_list([*reversed(self._files), *buffers])

    def close(self, name: str) -> None:
        """Close a file; the reader and the writer become the keyboard and the screen, if they were it.

        Raises:
            LogoError: it is not open, or it cannot be written to its end.
        """
        file = self._files.pop(name, None)
        if file is None:
            raise not_open(name, "ALLOPEN tells which are.")
        if self.reader == name:
            self.reader = None
        if self.writer == name:
            self._write_to(None)
        file.close()

    def close_buffer(self, target: List) -> Value:
        """Close a buffer and give what was written into it."""
        buffer = self._buffer(target)
        if buffer is None:
            raise not_open("buffer", "OPENWRITE opens a buffer; it wants the same list, and no copy of it.")
        self._buffers.remove(buffer)
        if self.writer is target:
            self._write_to(None)
        return buffer.value()

    def close_all(self) -> None:
        """Close everything; what is in buffers is lost.

        Raises:
            LogoError: a file could not be written to its end; the others are closed.
        """
        self._buffers.clear()
        self.to_terminal()
        try:
            for name in list(self._files):
                self.close(name)
        finally:
            for name in list(self._files):
                try:
                    self.close(name)
                except LogoError:
                    continue

    def finish(self, *, failed: bool) -> None:
        """The program has ended: close everything, the dribble file, too. One failure is enough to be told."""
        try:
            try:
                self.close_all()
            finally:
                self.stop_dribbling()
        except LogoError:
            if not failed:
                raise

    def erase(self, name: str) -> None:
        """Delete a file; one that is not there already is."""
        try:
            self.path(name).unlink(missing_ok=True)
        except OSError as error:
            raise cannot_open(name, error, self.path(name)) from None

    def read_all(self, name: str) -> str:
        """The whole text of a file.

        Raises:
            LogoError: it cannot be read.
        """
        path = self.path(name)
        try:
            return decode(path.read_bytes(), path).removeprefix("\ufeff")
        except OSError as error:
            raise cannot_open(name, error, path) from None
        except ValueError:
            raise cannot_open(name, OSError(0, "no file can have this name"), path) from None

    # --- reading ----------------------------------------------------------------------------------------------

    def read_from(self, name: str | None) -> None:
        """Read a file from now on, or the keyboard."""
        if name is not None:
            file = self._files.get(name)
            if file is None or not file.can_read:
                raise not_open(name, f'Open it for reading first: openread "{spelled(name)}')
        self.reader = name

    @property
    def reading(self) -> OpenFile | None:
        """The file that is read, ``None`` for the keyboard."""
        return None if self.reader is None else self._files[self.reader]

    def read_line(self) -> str | None:
        """The next line without its newline; ``None`` at the end."""
        line = (self.reading or self.keyboard).read_line()
        if self.reader is None and self._dribble is not None:
            self._dribble.write(line)
        if not line:
            return None
        return line.removesuffix("\n").removesuffix("\r")

    def read_character(self) -> str:
        """The next character; ``""`` at the end."""
        return (self.reading or self.keyboard).read_character()

    # --- writing ----------------------------------------------------------------------------------------------

    def write_to(self, target: str | List | None) -> None:
        """Write to a file or buffer from now on, or to the screen.

        Raises:
            LogoError: it is not open for writing.
        """
        if isinstance(target, str):
            file = self._files.get(target)
            if file is None or not file.can_write:
                raise not_open(target, f'Open it for writing first: openwrite "{spelled(target)}')
        self._write_to(target)

    def _write_to(self, target: str | List | None) -> None:
        self.writer = target
        self._divert()

    def _divert(self) -> None:
        """Have the interpreter's ``write`` go where it belongs: straight to the screen unless there is a reason."""
        logo = self._logo
        if self.writer is None and self._dribble is None:
            if logo.write is self._diverted:
                logo.write = self._screen
        elif logo.write is not self._diverted:
            self._screen, logo.write = logo.write, self._diverted

    @property
    def writing(self) -> OpenFile | Buffer | None:
        """What is written, ``None`` for the screen."""
        if self.writer is None:
            return None
        return self._files[self.writer] if isinstance(self.writer, str) else self._buffer(self.writer)

    def _write(self, text: str) -> None:
        target = self.writing
        if target is not None:
            target.write(text)
            return
        self._screen(text)
        if self._dribble is not None:
            self._dribble.write(text)

    def tell(self, text: str) -> None:
        """Write to the screen, whatever SETWRITE has set: what is asked there, and shown to be looked at."""
        if self._dribble is not None:
            self._dribble.write(text)
        (self._screen if self._logo.write is self._diverted else self._logo.write)(text)

    def implicit_buffer(self) -> List | None:
        """The list whose buffer the next SETWRITE closes."""
        target = self.writing
        return target.target if isinstance(target, Buffer) and target.is_implicit else None

    def to_terminal(self) -> None:
        """Read the keyboard and write to the screen again."""
        self.reader = None
        self._write_to(None)

    # --- the dribble file -------------------------------------------------------------------------------------

    def dribble(self, name: str) -> None:
        """Copy what is on the screen to a file, too.

        Raises:
            LogoError: this is done already, or the file cannot be opened.
        """
        if self._dribble is not None:
            raise LogoError(_ALREADY_DRIBBLING, "Already dribbling", hint="NODRIBBLE ends it.")
        self._dribble = OpenFile(name, self.path(name), "wb")
        self._divert()

    def stop_dribbling(self) -> None:
        """Close the dribble file, if there is one."""
        file, self._dribble = self._dribble, None
        self._divert()
        if file is not None:
            file.close()


def name_or_nil(name: str | List | None) -> Value:
    """The name of a stream as READER and WRITER output it: the empty list for the terminal."""
    return NIL if name is None else name
