"""JUnit XML as Jenkins, GitLab and GitHub's actions read it. A batch has a testsuite for each scene and a testcase for
each expectation. A sweep has one testsuite with a testcase for each case.

GitLab shows a testcase's `classname` as its suite, and Jenkins groups by it, so it names the scene too. The property
`formulation` of a testsuite is the one that ran.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from datetime import datetime, timezone
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as Xml

from mbproj.cli.report.expectations import error_words, subject, verdict, wanted
from mbproj.dataclass import dataclass
from mbproj.errors import ExitCode
from mbproj.outputs.escapes import escaped_text

if TYPE_CHECKING:
    from mbproj.analysis import Outcome
    from mbproj.studies.batch import SceneResult

#: Characters that XML 1.0 does not allow, even escaped.
UNPRINTABLE = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")


def junit(results: Sequence[SceneResult], not_run: Sequence[Path] = ()) -> str:
    """The results as XML. The first testcase of each scene, "runs", is an error where the scene could not run, and
    skipped where the batch was interrupted before."""
    root = Xml.Element("testsuites", name="mbproj batch")
    for result in results:
        root.append(_suite(result))
    for scene in not_run:
        suite = _new_suite(scene, tests=1, skipped=1)
        Xml.SubElement(_case(suite, scene, "runs", 0.0), "skipped", message="interrupted")
        root.append(suite)
    root.set("time", f"{sum(result.seconds for result in results):.3f}")
    return _whole_text(root)


@dataclass(frozen=True)
class SweepCase:
    """A case of a sweep: its name, its result, the reason of a failure, and its duration in s."""

    name: str
    status: str
    message: str
    seconds: float


def cases_as_xml(spec: Path, cases: Sequence[SweepCase]) -> str:
    """The cases of a sweep as XML: one that failed is an error, one that did not run is skipped."""
    root = Xml.Element("testsuites", name="mbproj sweep")
    skipped = sum(case.status == "not run" for case in cases)
    errors = sum(case.status not in ("done", "not run") for case in cases)
    suite = _new_suite(spec, len(cases), 0, errors, skipped, sum(case.seconds for case in cases))
    for case in cases:
        made = _case(suite, spec, case.name, case.seconds)
        if case.status == "not run":
            Xml.SubElement(made, "skipped", message="not run")
        elif case.status != "done":
            first, _, _ = case.message.partition("\n")
            Xml.SubElement(made, "error", message=_text(first), type=case.status).text = _text(case.message)
    root.append(suite)
    root.set("time", suite.get("time", "0"))
    return _whole_text(root)


def _whole_text(root: Xml.Element) -> str:
    for key in ("tests", "failures", "errors"):  # Jenkins' schema has no `skipped` here
        root.set(key, str(sum(int(suite.get(key, "0")) for suite in root)))
    Xml.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{Xml.tostring(root, encoding="unicode")}\n'


def _suite(result: SceneResult) -> Xml.Element:
    failures = sum(not outcome.holds for outcome in result.outcomes)
    failed = result.code not in (ExitCode.DONE, ExitCode.CHECK_FAILED)
    suite = _new_suite(result.scene, 1 + len(result.outcomes), failures, int(failed), seconds=result.seconds)
    if result.formulation is not None:
        properties = Xml.SubElement(suite, "properties")
        Xml.SubElement(properties, "property", name="formulation", value=result.formulation)
    runs = _case(suite, result.scene, "runs", result.seconds)
    if failed:
        first, _, _ = result.message.partition("\n")
        error = Xml.SubElement(runs, "error", message=_text(first), type=result.word)
        error.text = _text(result.message)
    for outcome in result.outcomes:
        case = _case(suite, result.scene, outcome.expectation.name, 0.0)
        if not outcome.holds:
            failure = Xml.SubElement(case, "failure", message=_text(error_words(outcome)), type=verdict(outcome))
            failure.text = _text(_full_message(outcome))
    return suite


def _new_suite(
    scene: Path, tests: int, failures: int = 0, errors: int = 0, skipped: int = 0, seconds: float = 0.0
) -> Xml.Element:
    counts = {"tests": tests, "failures": failures, "errors": errors, "skipped": skipped}
    return Xml.Element(
        "testsuite",
        {"name": _text(str(scene)), **{key: str(count) for key, count in counts.items()}},
        time=f"{seconds:.3f}",
        timestamp=datetime.now(timezone.utc).strftime("%Y-%m-%dT%H:%M:%S"),
    )


def _case(suite: Xml.Element, scene: Path, name: str, seconds: float) -> Xml.Element:
    """A testcase. Its classname is the path with dots, because Jenkins takes dots for its packages."""
    where = ".".join(part for part in scene.with_suffix("").parts if part.strip("./"))
    attributes = {"classname": _text(where), "name": _text(name), "file": _text(scene.as_posix())}
    return Xml.SubElement(suite, "testcase", attributes, time=f"{seconds:.3f}")


def _full_message(outcome: Outcome) -> str:
    """The full message of an expectation that is not met."""
    expected, measured = outcome.expectation, outcome.measured
    found = "nothing" if measured is None else ", ".join(f"{value:.17g}" for value in measured)
    lines = [
        subject(expected),
        f"expected: {wanted(expected)}",
        f"found: {found} {expected.unit}".rstrip(),
        f"error: {error_words(outcome)}",
        f"source: {expected.source}",
    ]
    return "\n".join(lines)


def _text(text: str) -> str:
    """The text without characters that XML does not allow, or that control a terminal."""
    return UNPRINTABLE.sub("?", escaped_text(text))
