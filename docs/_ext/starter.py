"""A program `warprock` for the commands of the manual that starts at once.

Of the seconds that a command takes, most go into importing what it needs. One process imports all
of it and then forks for every command, which has its folder, its environment and its output from
the program of this name that the shell finds first, and hands its exit code back to it.
"""

from __future__ import annotations

import contextlib
import importlib
import json
import os
import pathlib
import signal
import socket
import subprocess
import sys
import traceback
from collections.abc import Iterator

ROOT = pathlib.Path(__file__).resolve().parent.parent.parent
LEFT_OUT = ("warprock.__main__", "warprock.programs.")
"""What is run when it is imported, and what needs what is not installed everywhere."""

CALLER = """#!{python} -SE
import json, os, socket, sys
asked = json.dumps([sys.argv[1:], os.getcwd(), dict(os.environ)]).encode()
with socket.socket(socket.AF_UNIX) as there:
    there.connect({place!r})
    socket.send_fds(there, [len(asked).to_bytes(8, "big")], [0, 1, 2])
    there.sendall(asked)
    sys.exit(int(there.recv(8) or b"1"))
"""


@contextlib.contextmanager
def started(folder: pathlib.Path) -> Iterator[pathlib.Path]:
    """A folder whose program `warprock` does what the one of this checkout does, in less time.

    Args:
        folder: An empty folder, of a short name.
    """
    place, program = folder / "socket", folder / "bin" / "warprock"
    program.parent.mkdir()
    program.write_text(CALLER.format(python=sys.executable, place=str(place)), encoding="utf-8")
    program.chmod(0o755)
    with subprocess.Popen(
        [sys.executable, __file__, str(place)], stdout=subprocess.PIPE, cwd=ROOT
    ) as server:
        try:
            assert server.stdout is not None
            if server.stdout.readline() != b"ready\n":
                raise OSError(f"{__file__} did not start")
            yield program.parent
        finally:
            server.terminate()


def serve(place: str) -> None:
    """Answers calls for ever."""
    for path in sorted((ROOT / "warprock").rglob("*.py")):
        module = ".".join(path.relative_to(ROOT).with_suffix("").parts)
        if not module.startswith(LEFT_OUT):
            importlib.import_module(module.removesuffix(".__init__"))
    with socket.socket(socket.AF_UNIX) as here:
        here.bind(place)
        here.listen()
        signal.signal(signal.SIGCHLD, signal.SIG_IGN)
        print("ready", flush=True)
        while True:
            call, _ = here.accept()
            if os.fork() == 0:
                here.close()
                _answer(call)
            call.close()


def _answer(call: socket.socket) -> None:
    """Runs one command in this process, which ends with it."""
    signal.signal(signal.SIGCHLD, signal.SIG_DFL)
    size, files, _, _ = socket.recv_fds(call, 8, 3)
    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    with call.makefile("rb") as asked:
        words, folder, environment = json.loads(asked.read(int.from_bytes(size, "big")))
    os.chdir(folder)
    os.environ.clear()
    os.environ.update(environment)
    sys.argv = ["warprock", *words]
    code = 1
    try:
        from warprock.cli.main import entry

        entry()
        code = 0
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
    except BaseException:
        traceback.print_exc()
    with contextlib.suppress(OSError):
        sys.stdout.flush()
        sys.stderr.flush()
    call.sendall(str(code).encode())
    os._exit(code)


if __name__ == "__main__":
    sys.path.insert(0, str(ROOT))
    serve(sys.argv[1])
