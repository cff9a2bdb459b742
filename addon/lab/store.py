# SPDX-License-Identifier: GPL-3.0-or-later
"""What a chart's folder keeps: chart.json (of what, and the plan), and each finished render as a picture and figures.

Each file is written beside its place and moved there, so that a chart that was stopped holds whole renders only.
"""

from __future__ import annotations

import errno
import json
import os
from dataclasses import dataclass
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np

from ..metrics import Image
from ..terminal import WRONG_ARGUMENTS, CommandError
from .plan import Job, Plan

if os.name == 'nt':
    import msvcrt
else:
    import fcntl

VERSION = 1


@dataclass(frozen=True, slots=True)
class Render:
    """A finished render. Seconds: `wall` of sampling and denoising, `cpu` the same on all processors, `whole` as the
    user waits for them, with export, BVH and saving.
    """

    job: Job
    wall: float
    cpu: float
    whole: float
    image: Image


class Store:
    """A folder. `identity` says what is charted: text by name, all of which must be as they were to go on."""

    def __init__(self, folder: Path, identity: dict[str, Any]) -> None:
        self.folder = folder
        self.identity = json.loads(json.dumps(identity))
        self.renders = folder / 'renders'
        self.lock: BinaryIO | None = None
        self.info: dict[str, Any] = {}  # of the scene, as the worker found it

    def open(self, fresh: bool) -> Plan | None:
        """The plan that is there, to be gone on with. CommandError where the folder is another chart's, or at work.

        fresh: what is there is thrown away.
        """
        try:
            self.renders.mkdir(parents=True, exist_ok=True)
            probe = self.renders / '.probe'
            probe.write_bytes(b'')
            probe.unlink()
        except OSError as error:
            raise CommandError(f'{self.folder}: cannot be written to: {error.strerror}') from error
        self.claim()
        if fresh:
            self.clear()
        file = self.folder / 'chart.json'
        try:
            content = json.loads(file.read_text(encoding='utf-8'))
            known, plan = content['identity'], Plan.read(content['plan'])
            self.info = content['info']
        except FileNotFoundError:
            return None
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise CommandError(f'{file}: cannot be read ({error}); --fresh begins anew', WRONG_ARGUMENTS) from error
        changed = [name for name in {**known, **self.identity} if known.get(name) != self.identity.get(name)]
        if changed:
            told = ', '.join(f'{name} {known.get(name)} (now {self.identity.get(name)})' for name in changed)
            raise CommandError(
                f'{self.folder}: holds a chart of another kind: {told}. Take another folder, or --fresh to begin anew',
                WRONG_ARGUMENTS,
            )
        return plan

    def claim(self) -> None:
        """Keeps other processes from charting into the folder as long as this one lives; CommandError where one does.

        The system lets go of the lock when the process ends, however it does.
        """
        self.lock = (self.folder / '.lock').open('ab')
        try:
            if os.name == 'nt':
                msvcrt.locking(self.lock.fileno(), msvcrt.LK_NBLCK, 1)
            else:
                fcntl.flock(self.lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError as error:
            raise self.taken() from error
        except OSError as error:
            # Windows says so of a file that is locked; some network folders know no locks: there nobody is kept out.
            if os.name == 'nt' and error.errno in (errno.EACCES, errno.EDEADLK):
                raise self.taken() from error

    def close(self) -> None:
        """Lets others chart into the folder."""
        if self.lock is not None:
            self.lock.close()

    def taken(self) -> CommandError:
        return CommandError(f'{self.folder}: another process makes a chart there; take another folder', WRONG_ARGUMENTS)

    def clear(self) -> None:
        for path in [self.folder / 'chart.json', *self.renders.glob('*.json'), *self.renders.glob('*.npy')]:
            path.unlink(missing_ok=True)

    def write_plan(self, plan: Plan) -> None:
        content = {'version': VERSION, 'identity': self.identity, 'info': self.info, 'plan': plan.content()}
        replace_text(self.folder / 'chart.json', json.dumps(content, indent=1))

    def has(self, job: Job) -> bool:
        return (self.renders / f'{job.key}.json').is_file()

    def keep(self, job: Job, answer: dict[str, Any]) -> None:
        """The worker's answer to a job; its picture is moved here."""
        os.replace(answer['image'], self.renders / f'{job.key}.npy')
        figures = {name: answer[name] for name in ('wall', 'cpu', 'whole')}
        replace_text(self.renders / f'{job.key}.json', json.dumps({'job': job.content(), **figures}))

    def all(self) -> list[Render]:
        """All renders that are whole."""
        found = []
        for path in sorted(self.renders.glob('*.json')):
            try:
                content = json.loads(path.read_text(encoding='utf-8'))
                job = Job.read(content.pop('job'))
                found.append(Render(job, image=np.load(path.with_suffix('.npy')), **content))
            except (OSError, ValueError, KeyError, TypeError):
                path.unlink(missing_ok=True)  # it is rendered again
        return found


def replace_text(path: Path, text: str) -> None:
    new = path.with_name(path.name + '.new')
    new.write_text(text, encoding='utf-8')
    os.replace(new, path)
