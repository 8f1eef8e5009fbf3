"""JUnit's XML is XML, whatever a path or a message holds."""

from __future__ import annotations

from pathlib import Path
from xml.etree import ElementTree as Xml

from mbproj.base.errors import ExitCode
from mbproj.commands.report.junit import junit
from mbproj.studies.batch import SceneResult


def test_what_xml_cannot_say_and_what_commands_a_terminal_can_be_read():
    scene, message = Path("a\x1b[31m\udcff.yaml"), "\x1b]0;t\x07 \ufffe <&>\nsecond"
    text = junit([SceneResult(scene, ExitCode.FAILED, message, (), 1.0)], [Path("b\x00\x7f.yaml")])
    root = Xml.fromstring(text.encode())
    assert root[0].get("name") == "a\\u001b[31m?.yaml"
    error = root[0][0].find("error")
    assert error is not None and error.get("message") == "\\u001b]0;t\\u0007 ? <&>"
    assert error.text == "\\u001b]0;t\\u0007 ? <&>\nsecond"
    assert root[1].get("name") == "b\\u0000\\u007f.yaml"
