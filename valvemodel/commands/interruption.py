"""How Ctrl-C and `kill` reach a running command: as an exception that is neither lost nor ends the process itself."""

from __future__ import annotations

import os
import signal
import sys
import threading
from types import FrameType
from typing import Any

DEFERRED = 0.02
"""How long a signal waits that came where its exception would be lost. [s]"""


class Interruption(KeyboardInterrupt):
    """Ctrl-C or `kill`.

    Where KeyboardInterrupt itself leaves code that `exec` runs from a text, as in the import of many a library, the
    interpreter ends by the signal later on, whatever its exit status was to be; a class derived from it is spared.
    """


def listen() -> None:
    """Let SIGINT and SIGTERM send the workers of this process home and raise `Interruption` in it."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _interrupt(os.getpid()))


def _interrupt(main_process: int) -> Any:
    """Return what a signal does: workers end silently, the main process sends its workers home and stops."""

    def interrupt(number: int, frame: FrameType | None) -> None:
        if os.getpid() != main_process:
            os._exit(128 + number)
        if _is_lost(frame):
            again = threading.Timer(DEFERRED, signal.pthread_kill, (threading.main_thread().ident, number))
            again.daemon = True
            again.start()
            return
        if multiprocessing := sys.modules.get("multiprocessing"):
            for worker in multiprocessing.active_children():
                worker.terminate()
        raise Interruption

    return interrupt


def _is_lost(frame: FrameType | None) -> bool:
    """Return whether an exception would be lost: in a finaliser, or below llvmlite, which calls back from C."""
    while frame is not None:
        if frame.f_code.co_name == "__del__" or frame.f_globals.get("__name__", "").startswith("llvmlite."):
            return True
        frame = frame.f_back
    return False
