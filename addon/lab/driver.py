# SPDX-License-Identifier: GPL-3.0-or-later
"""Starts the worker, gives it jobs until all is rendered or time is up, and keeps each render in the store.

It knows what things take by what they took; it renders nothing and computes no error.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

from ..terminal import FAILED, CommandError, TerminalWatcher
from . import plan
from .plan import Job, Plan, Series
from .store import Store

POLL_SECONDS = 0.01
# A render that is late ends the chart at this part of the budget beyond it, and is lost.
OVERRUN = 0.04
# Of the time that is planned with, so much is used: renders take longer than foretold.
PLANNED = 0.85
# The pilot asks no more series once it took so much of the budget.
PILOT_SHARE = 0.3
# Of the time that is left over, one more number of samples may take so much.
RUNG_SHARE = 0.7


def worker_command() -> list[str]:
    """How a worker is started, its folder's path to be added; COTORRA_WORKER (JSON) says so where Blender asks."""
    given = os.environ.get('COTORRA_WORKER')
    return json.loads(given) if given else [sys.executable, '-P', '-m', f'{__package__}.worker']


class Worker:
    """The process that renders; a context manager, which ends it."""

    def __init__(self, task: dict[str, Any]) -> None:
        self._task = task
        self._number = 0

    def __enter__(self) -> Worker:
        self._folder = tempfile.TemporaryDirectory(prefix='cotorra-chart-', ignore_cleanup_errors=True)
        self.folder = Path(self._folder.name)
        (self.folder / 'task.json').write_text(json.dumps(self._task), encoding='utf-8')
        self._log = (self.folder / 'log.txt').open('wb')
        # A session of its own: Ctrl-C at the terminal is for us to answer.
        self._process = subprocess.Popen(
            [*worker_command(), str(self.folder)],
            stdin=subprocess.PIPE,
            stdout=self._log,
            stderr=subprocess.STDOUT,
            start_new_session=os.name == 'posix',
        )
        return self

    def __exit__(self, *_: object) -> None:
        self._process.kill()
        self._process.wait()
        self._process.stdin.close()
        self._log.close()
        self._folder.cleanup()

    def opened(self, stop: Callable[[], bool]) -> dict[str, Any] | None:
        """What the worker says of the scene; None where `stop` ended the wait. CommandError where that fails."""
        found = self._answer(stop)
        if found is not None and 'error' in found:
            raise CommandError(found['error'], found['code'])
        return found

    def render(self, job: Job, stop: Callable[[], bool]) -> dict[str, Any] | None:
        """The answer to a job; None where `stop` ended the wait: then no other job can be given."""
        self._number += 1
        line = {**job.content(), 'number': self._number}
        try:
            self._process.stdin.write(json.dumps(line).encode() + b'\n')
            self._process.stdin.flush()
        except OSError:
            pass  # it has ended, and is asked why
        return self._answer(stop)

    def _answer(self, stop: Callable[[], bool]) -> dict[str, Any] | None:
        file = self.folder / f'{self._number}.json'
        while not file.exists():
            if stop():
                return None
            if self._process.poll() is not None and not file.exists():
                self._log.flush()
                words = (self.folder / 'log.txt').read_text(encoding='utf-8', errors='replace').splitlines()[-8:]
                told = '\n  '.join(['Blender ended', f'exit status {self._process.returncode}', *words])
                raise CommandError(told, FAILED)
            time.sleep(POLL_SECONDS)
        return json.loads(file.read_text(encoding='utf-8'))


class Costs:
    """What renders took: samples, seconds of rendering and of all, by series."""

    def __init__(self) -> None:
        self._known: dict[Series, list[tuple[int, float, float]]] = {}

    def learn(self, job: Job, wall: float, whole: float) -> None:
        self._known.setdefault(job.series, []).append((job.samples, wall, whole))

    def knows(self, series: Series) -> bool:
        return series in self._known

    def whole(self, job: Job) -> float:
        """Seconds that a job will take; of a series that was not rendered yet, as the dearest of the others."""
        known = self._known.get(job.series)
        if known is None:
            others = [Job(series, job.samples, job.seed) for series in self._known]
            return max((self.whole(other) for other in others), default=0.0)
        few, many = min(known), max(known)
        near = min(known, key=lambda entry: abs(entry[0] - job.samples))
        rate = near[1] / near[0]
        if many[0] > few[0]:
            rate = max(0.0, (many[1] - few[1]) / (many[0] - few[0]))
        elif job.series.denoised:  # most of it may be the denoiser's
            noisy = self._known.get(replace(job.series, denoised=False), known)
            rate = noisy[0][1] / noisy[0][0]
        return near[2] + rate * (job.samples - near[0])


class Driver:
    """Renders what a plan asks for and the store has not. deadline: of renders, by time.perf_counter; None for none."""

    def __init__(self, store: Store, watcher: TerminalWatcher, budget: float | None, began: float) -> None:
        self.store, self.watcher = store, watcher
        self.budget, self.began = budget, began
        self.deadline: float | None = None
        self.costs = Costs()
        self.failed: dict[Series, str] = {}
        self.rendered_seconds = 0.0  # of the renders of this run, as their user would have waited

    def run(
        self, task: dict[str, Any], chart: Plan | None, make: Callable[[], Plan], closing: Callable[[Plan], float]
    ) -> Plan:
        """Opens the scene, plans where there is no plan yet, and renders; the plan, whose jobs may not all be done.

        make: the plan that was asked for. closing: seconds that drawing will take.
        """
        if chart is not None and self.store.info and self.budget is None and all(map(self.store.has, chart.jobs())):
            return chart
        with Worker(task) as worker:
            self.watcher.status('Opening the scene')
            info = worker.opened(self._stopped)
            if info is None:
                return chart or make()
            self.store.info = info
            for render in self.store.all():
                self.costs.learn(render.job, render.wall, render.whole)
            chart = chart or make()
            if not self._prepare(worker, chart, closing):
                return chart
            self.store.write_plan(chart)
            todo = [job for job in chart.jobs() if not self.store.has(job)]
            done = len(chart.jobs()) - len(todo)
            for position, job in enumerate(todo):
                if self._late(job) or job.series in self.failed:
                    continue
                left = sum(self.costs.whole(later) for later in todo[position:])
                if self.deadline is not None:
                    left = min(left, self.deadline - time.perf_counter())
                self._show(job, done + position, len(chart.jobs()), left)
                if not self._render(worker, job):
                    return chart
            self._use_what_is_left(worker, chart, closing)
        return chart

    def _prepare(self, worker: Worker, chart: Plan, closing: Callable[[Plan], float]) -> bool:
        """Renders once by each engine and device, for what only the first render of a process pays; then the budget."""
        first: dict[tuple[str, str], Series] = {}
        for series in [*chart.references(), *chart.series]:
            first.setdefault((series.engine, series.device), series)
        for series in first.values():
            self.watcher.status(f'{series.name}: first render')
            if not self._render(worker, Job(series, 1, plan.PILOT_SEED), keep=False):
                return False
        if self.budget is None:
            return True
        if not chart.samples:
            for series in dict.fromkeys([*chart.references(), *chart.series]):
                job = Job(series, plan.PILOT_SAMPLES, plan.PILOT_SEED)
                if self.store.has(job) or series in self.failed:
                    continue
                if series not in chart.references()[:1] and self._spent() > PILOT_SHARE * self.budget:
                    chart.series = [other for other in chart.series if self.costs.knows(other)]
                    break
                self.watcher.status(f'{series.name}: pilot')
                if not self._render(worker, job):
                    return False
            chart.samples = plan.ladder(plan.PILOT_SAMPLES, plan.RUNGS)
            left = self.budget - self._spent() - closing(chart)
            plan.fit_to_budget(chart, self.costs.whole, PLANNED * left)
        self.deadline = self.began + self.budget - closing(chart)
        return True

    def _spent(self) -> float:
        return time.perf_counter() - self.began

    def _late(self, job: Job) -> bool:
        return self.deadline is not None and time.perf_counter() + self.costs.whole(job) > self.deadline

    def _use_what_is_left(self, worker: Worker, chart: Plan, closing: Callable[[Plan], float]) -> None:
        """Twice the most samples, where that fits; then more parts of the references, as long as the budget lasts."""
        if self.deadline is None:
            return
        self.deadline = self.began + self.budget - closing(chart)
        more = replace(chart, samples=[2 * chart.samples[-1]]).point_jobs()
        fits = sum(map(self.costs.whole, more)) < RUNG_SHARE * (self.deadline - time.perf_counter())
        if fits and len(chart.series) * (len(chart.samples) + 1) <= chart.points:
            chart.reference_samples = plan.PARTS * chart.part_samples()
            chart.samples.append(more[0].samples)
            self.store.write_plan(chart)
            for job in more:
                if self._late(job) or job.series in self.failed:
                    continue
                self.watcher.status(f'{job.series.name}, {job.samples} samples, seed {job.seed}')
                if not self._render(worker, job):
                    return
        part = plan.PARTS
        while True:
            jobs = [job for job in chart.reference_jobs(part, part + 1) if job.series not in self.failed]
            if not jobs or sum(self.costs.whole(job) for job in jobs) > self.deadline - time.perf_counter():
                return
            for job in jobs:
                if not self.store.has(job):
                    self.watcher.status(f'{job.series.name}: reference, part {part + 1}')
                    if not self._render(worker, job):
                        return
            part += 1

    def _render(self, worker: Worker, job: Job, keep: bool = True) -> bool:
        """False where nothing more can be rendered: it was stopped, or is too late."""
        answer = worker.render(job, self._stopped)
        if answer is None:
            return False
        for text in answer.get('warnings', ()):
            self.watcher.message('WARNING', text)
        if 'error' in answer:
            self.failed[job.series] = answer['error']
            self.watcher.message('WARNING', f'{answer["error"]}; it is left out')
            return True
        self.rendered_seconds += answer['whole']
        if keep:
            self.costs.learn(job, answer['wall'], answer['whole'])
            self.store.keep(job, answer)
        return True

    def _stopped(self) -> bool:
        if self.watcher.stop:
            return True
        if self.deadline is None:
            return self.budget is not None and time.perf_counter() > self.began + self.budget
        return time.perf_counter() > self.deadline + OVERRUN * self.budget

    def _show(self, job: Job, done: int, count: int, left: float) -> None:
        what = f'reference, part {job.seed - plan.REFERENCE_SEED + 1}' if job.reference else f'seed {job.seed}'
        words = f'{done + 1}/{count} {job.series.name}, {job.samples} samples, {what}'
        self.watcher.status(words, done / count, time.perf_counter() - self.began, max(0.0, left))
