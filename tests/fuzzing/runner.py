# SPDX-License-Identifier: GPL-3.0-or-later
"""Runs the process that renders fuzzed scenes (worker.py), and starts it again when a scene made it crash or hang."""

from __future__ import annotations

import json
import os
import queue
import signal
import subprocess
import sys
import tempfile
import threading
import time
from pathlib import Path
from typing import Any

Description = dict[str, Any]
WORKER = Path(__file__).resolve().parent / 'worker.py'
START_SECONDS = 120.0


class Runner:
    """seconds: of processor time that a scene may take, and a tenth of the seconds, before it counts as hanging.

    build_only: nothing is rendered.
    """

    def __init__(self, seconds: float = 60.0, build_only: bool = False) -> None:
        self.seconds = seconds
        self.build_only = build_only
        self.processor_seconds = 0.0
        self.worker: subprocess.Popen[str] | None = None
        self.catalogue = self.start()

    def start(self) -> dict[str, Any]:
        self.told = tempfile.TemporaryFile('w+')
        command = [sys.executable, '-u', '-X', 'faulthandler', str(WORKER), *(['--build'] if self.build_only else [])]
        self.worker = subprocess.Popen(
            command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=self.told, text=True
        )
        self.answers: queue.Queue[str] = queue.Queue()
        threading.Thread(target=self.listen, args=(self.worker.stdout, self.answers), daemon=True).start()
        line = self.answers.get(timeout=START_SECONDS)
        if not line:
            raise RuntimeError(f'the process that renders did not start: {self.last_words()}')
        return json.loads(line)

    @staticmethod
    def listen(stream: Any, answers: queue.Queue[str]) -> None:
        for line in stream:
            if line.startswith('{'):  # Blender writes there, too, before the process can turn it away
                answers.put(line)
        answers.put('')

    def close(self) -> None:
        if self.worker is not None:
            self.worker.kill()
            self.worker.wait()
            self.worker = None
            self.told.close()

    def last_words(self) -> str:
        self.told.seek(0, os.SEEK_END)
        self.told.seek(max(self.told.tell() - 3000, 0))
        return self.told.read()

    def answer(self) -> str:
        """Raises queue.Empty where the process hangs. On a busy machine little processor time passes in a minute."""
        began, used = time.monotonic(), self.used()
        while True:
            try:
                return self.answers.get(timeout=min(self.seconds, 1.0))
            except queue.Empty:
                if self.used() - used > self.seconds or time.monotonic() - began > 10.0 * self.seconds:
                    raise

    def used(self) -> float:
        """Processor time of the process so far, in seconds, where the system tells it in /proc."""
        try:
            fields = Path(f'/proc/{self.worker.pid}/stat').read_text().rpartition(')')[2].split()
        except OSError:
            return 0.0
        return (int(fields[11]) + int(fields[12])) / os.sysconf('SC_CLK_TCK')

    def verdict(self, description: Description) -> dict[str, Any]:
        """fault: what is wrong, '' where nothing is; beside it error, warnings and seconds of processor time."""
        if self.worker is None:
            self.start()
        try:
            self.worker.stdin.write(json.dumps(description) + '\n')
            self.worker.stdin.flush()
            line = self.answer()
        except queue.Empty:
            self.worker.send_signal(signal.SIGABRT)  # faulthandler tells where
            self.worker.wait()
            words = self.last_words()
            self.close()
            return {'fault': f'hangs for more than {self.seconds:g} s of processor time: {words}', 'kind': 'hang'}
        except BrokenPipeError:
            line = ''
        if not line:
            code = self.worker.wait()
            words = self.last_words()
            self.close()
            return {'fault': f'crash ({code}): {words}', 'kind': 'crash'}
        found = json.loads(line)
        self.processor_seconds += found['seconds']
        return found
