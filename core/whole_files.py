"""Files and folders that appear whole or not at all."""

from __future__ import annotations

import os
import shutil
from contextlib import contextmanager
from pathlib import Path

from .errors import InputError


@contextmanager
def refusing(path):
    """Turn a failure of the file system into an InputError that names the file."""
    try:
        yield
    except OSError as error:
        raise InputError(
            f"{path} cannot be written ({error.strerror}); choose another place for it."
        ) from None


def write_whole(path, data: bytes) -> None:
    """Write a file under a temporary name beside its place, then put it there.

    Raises InputError when it cannot be written; an older file of that name then stays.
    """
    path = Path(os.path.realpath(path))
    unfinished = path.with_name(f".{path.name}-{os.getpid()}.unfinished")
    with refusing(path):
        try:
            unfinished.write_bytes(data)
            os.replace(unfinished, path)
        finally:
            unfinished.unlink(missing_ok=True)


def write_whole_with_folder(path, data: bytes, folder_name: str, files: dict) -> None:
    """Write a file and a folder of files beside it that it refers to.

    files  name -> bytes, the whole content of the folder

    The folder is made under a temporary name and takes the place of an older one, which must hold
    nothing but files of the same kinds. Raises InputError.
    """
    path = Path(os.path.realpath(path))
    folder = path.with_name(folder_name)
    unfinished = path.with_name(f".{folder_name}-{os.getpid()}.unfinished")
    older = path.with_name(f".{folder_name}-{os.getpid()}.older")
    _refuse_foreign(folder, {Path(name).suffix for name in files})
    with refusing(path):
        try:
            unfinished.mkdir()
            for name, content in files.items():
                (unfinished / name).write_bytes(content)
            if folder.exists():
                os.replace(folder, older)
            os.replace(unfinished, folder)
            write_whole(path, data)
        except BaseException:
            if older.exists():
                shutil.rmtree(folder, ignore_errors=True)
                os.replace(older, folder)
            raise
        finally:
            shutil.rmtree(unfinished, ignore_errors=True)
            shutil.rmtree(older, ignore_errors=True)


def _refuse_foreign(folder: Path, suffixes):
    if not folder.exists():
        return
    foreign = not folder.is_dir() or any(
        not entry.is_file() or entry.suffix not in suffixes for entry in folder.iterdir()
    )
    if foreign:
        raise InputError(f"{folder} holds other things than blocks; choose another name.")
