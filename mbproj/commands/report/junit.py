"""JUnit XML as Jenkins, GitLab and GitHub's actions read it. A batch has a testsuite for each scene and a testcase for
each expectation. A sweep has one testsuite with a testcase for each case.

GitLab shows a testcase's `classname` as its suite, and Jenkins groups by it, so it names the scene too. The property
`formulation` of a testsuite is the one that ran.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from datetime import datetime, timezone
from pathlib import Path
from typing import TYPE_CHECKING
from xml.etree import ElementTree as Xml

from mbproj.base.dataclass import dataclass
from mbproj.base.errors import ExitCode
from mbproj.base.text import escaped_text
from mbproj.commands.report.summary import error_words, expected_text, subject, verdict
from mbproj.results.report_schema.studies import FORMULATION

if TYPE_CHECKING:
    from mbproj.results.analysis.expectations import Outcome
    from mbproj.studies.batch import SceneResult

#: Characters that XML 1.0 does not allow, even escaped.
UNPRINTABLE = re.compile("[^\t\n\r\x20-\ud7ff\ue000-\ufffd\U00010000-\U0010ffff]")
#: The counts of a testsuite, and how the testcases that they count ended.
COUNTED = {"failures": "failure", "errors": "error", "skipped": "skipped"}


@dataclass(frozen=True)
class TestCase:
    """A testcase: its name, its duration in s, and how it `ended`: "" (well), "skipped", "error" or "failure". The last
    two have a `text`, a word for their `kind`, and a `message`, which is the first line of the text by default."""

    __test__ = False  # it is no test of pytest's
    name: str
    seconds: float = 0.0
    ended: str = ""
    text: str = ""
    kind: str = ""
    message: str = ""


def junit(results: Sequence[SceneResult], not_run: Sequence[Path] = ()) -> str:
    """The results as XML. The first testcase of each scene, "runs", is an error where the scene could not run, and
    skipped where the batch was interrupted before."""
    suites = [_suite(each.scene, list(_cases(each)), each.seconds, each.formulation) for each in results]
    suites += [_suite(scene, [TestCase("runs", 0.0, "skipped", "interrupted")], 0.0) for scene in not_run]
    return _as_xml("mbproj batch", suites, sum(each.seconds for each in results))


def cases_as_xml(spec: Path, cases: Sequence[TestCase]) -> str:
    """The cases of a sweep as XML."""
    seconds = sum(case.seconds for case in cases)
    return _as_xml("mbproj sweep", [_suite(spec, cases, seconds)], seconds)


def _cases(result: SceneResult) -> Iterator[TestCase]:
    """The testcases of a scene: that it runs, and its expectations."""
    failed = result.code not in (ExitCode.DONE, ExitCode.CHECK_FAILED)
    yield TestCase("runs", result.seconds, *(("error", result.message, result.word) if failed else ()))
    for outcome in result.outcomes:
        short = ("failure", _full_message(outcome), verdict(outcome), error_words(outcome))
        yield TestCase(outcome.expectation.name, 0.0, *(() if outcome.holds else short))


def _as_xml(name: str, suites: Sequence[Xml.Element], seconds: float) -> str:
    root = Xml.Element("testsuites", name=name)
    root.extend(suites)
    root.set("time", f"{seconds:.3f}")
    for key in ("tests", "failures", "errors"):  # Jenkins' schema has no `skipped` here
        root.set(key, str(sum(int(suite.get(key, "0")) for suite in root)))
    Xml.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{Xml.tostring(root, encoding="unicode")}\n'


def _suite(of: Path, cases: Sequence[TestCase], seconds: float, formulation: str | None = None) -> Xml.Element:
    """The testsuite of a scene or a sweep. The classname of its testcases is the path with dots, because Jenkins takes
    dots for its packages."""
    ended = [case.ended for case in cases]
    counts = {"tests": len(cases), **{key: ended.count(word) for key, word in COUNTED.items()}}
    suite = Xml.Element(
        "testsuite",
        {"name": _text(str(of)), **{key: str(count) for key, count in counts.items()}},
        time=f"{seconds:.3f}",
        timestamp=datetime.now(timezone.utc).strftime("%Y-%m-%dT%H:%M:%S"),
    )
    if formulation is not None:
        Xml.SubElement(Xml.SubElement(suite, "properties"), "property", name=FORMULATION.key, value=formulation)
    where = ".".join(part for part in of.with_suffix("").parts if part.strip("./"))
    for case in cases:
        attributes = {"classname": _text(where), "name": _text(case.name), "file": _text(of.as_posix())}
        element = Xml.SubElement(suite, "testcase", attributes, time=f"{case.seconds:.3f}")
        message = _text(case.message or case.text.partition("\n")[0])
        if case.ended == "skipped":
            Xml.SubElement(element, "skipped", message=message)
        elif case.ended:
            Xml.SubElement(element, case.ended, message=message, type=case.kind).text = _text(case.text)
    return suite


def _full_message(outcome: Outcome) -> str:
    """The full message of an expectation that is not met."""
    expected, measured = outcome.expectation, outcome.measured
    values = "nothing" if measured is None else ", ".join(f"{value:.17g}" for value in measured)
    lines = [
        subject(expected),
        f"expected: {expected_text(expected)}",
        f"found: {values} {expected.unit}".rstrip(),
        f"error: {error_words(outcome)}",
        f"source: {expected.source}",
    ]
    return "\n".join(lines)


def _text(text: str) -> str:
    """The text without characters that XML does not allow, or that control a terminal."""
    return UNPRINTABLE.sub("?", escaped_text(text))
