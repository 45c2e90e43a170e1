"""A process that does jobs, one after another: `python -m crackgrow.study.child FD`, FD being its end of a pipe."""

from __future__ import annotations

import os
import pickle
import queue
import sys
import threading
from multiprocessing.connection import Connection

from crackgrow.errors import reason_of


def main(descriptor: int) -> None:
    """Do what comes through the pipe, a pickled function with its arguments, and send back result and fault."""
    pipe = Connection(descriptor)
    jobs: queue.SimpleQueue[bytes] = queue.SimpleQueue()
    threading.Thread(target=_listen, args=(pipe, jobs), daemon=True).start()
    while True:
        try:
            function, arguments = pickle.loads(jobs.get())
            pipe.send((function(*arguments), ""))
        except Exception as error:
            pipe.send((None, reason_of(error)))


def _listen(pipe: Connection, jobs: queue.SimpleQueue[bytes]) -> None:
    """Take in jobs; end the process in the middle of one when nobody is there any more to wait for it."""
    try:
        while True:
            jobs.put(pipe.recv_bytes())
    except (EOFError, OSError):
        os._exit(0)


if __name__ == "__main__":
    main(int(sys.argv[1]))
