"""A node that cannot start says why on one line and ends with 2, whatever is wrong."""

import json
import os
import select
import sys
import time
from pathlib import Path
from subprocess import PIPE, Popen

import pytest
from peer import PROGRAM, Program, child_environment

from soft_sim_ros.node.parameters import TABLE

BACKBONE = "qos_overrides./soft_arm/backbone.publisher"
WRONG_VALUES = {
    "a string": ["5", "true", "[a, b]", "1.5", '"a\\nb"', '"\\e[31mred"'],
    "an integer": ["abc", "1.5", "true", "[1]", "99999999999999999999", "-1", "null"],
    "a number": ["abc", "true", "[1.0]", ".nan", ".inf", "-.inf", "-1.0", "1.0e-310", "1.0e+300"],
    "a boolean": ["5", "maybe", "[true]", "1.0"],
}
BAD_PARAMETERS = [
    f"{row.name}:={value}"
    for row in TABLE
    for value in WRONG_VALUES[row.type_name]
    if not (row.name in ("scene", "record") and value == '"\\e[31mred"')  # a test of its own
]
BAD_QUALITIES = [
    *(f"{BACKBONE}.reliability:={v}" for v in ("besteffort", "7", "[a]", "''", "unknown", "true")),
    *(f"{BACKBONE}.durability:={v}" for v in ("transientlocal", "x", "1.5")),
    *(f"{BACKBONE}.history:={v}" for v in ("keepall", "3")),
    *(f"{BACKBONE}.depth:={v}" for v in ("abc", "-1", "0", "1.5", "true", "2147483648", "1.0e+20")),
    f"{BACKBONE}.lifespan:=3",
    "qos_overrides./soft_arm/command.subscription.reliability:=besteffort",
    "qos_overrides./soft_arm/command.publisher.reliability:=reliable",
    "qos_overrides./clock.publisher.reliability:=besteffort",
    "qos_overrides.:=x",
]
BAD_OVERRIDES = [
    *("use_sim_time:=maybe", "use_sim_time:=1", "start_type_description_service:=5"),
    *("x", "=", ":=5", "a b:=5", "scene:=", "poses:={a: b}", "poses:=*a", "\x1b[31mx:=5"),
    *("poses:=!!python/object/apply:os.system [x]", "frame_id:=" + 300 * "a", "frame_id:=''"),
    *("scene:=/", "scene:=/dev/null", "scene:=''", 'scene:="\\e[31mred\\nline"', "scene:=\udcff"),
]
BAD_REMAPS = [
    *(f"__node:={n}" for n in ("bad name", "1arm", "arm-1", "", "arm/x", "äöü", 300 * "a", "/abs")),
    *(f"__ns:={n}" for n in ("/bad name", "left", "/1x", "/a//b", "", "/" + 300 * "a", "/end/")),
    *("~/backbone:=bad name", "~/backbone:=/1x", "backbone", "~/backbone:=", "x:=y:=z"),
    *("joint_states:=/x/{y}", "~/pause:=1 2", "~/command:=~/backbone"),
]
BAD_WORDS = [
    *(["hello"], ["--bad\nopt"], ["--ros-args", "--foo"], ["--ros-args", "-p"]),
    *(["--ros-args", "-r"], ["--ros-args", "--log-level", "loud"], ["--ros-args", "--params-file"]),
    ["--ros-args", "--enclave", "bad enclave"],
    ["scene:=x"],
]
BAD_FILES = {
    "binary": bytes(range(256)),
    "zeros": bytes(200),
    "latin-1": "soft_arm: {ros__parameters: {scene: 'ä'}}".encode("latin-1"),
    "utf-16": "soft_arm: {ros__parameters: {scene: no_such}}".encode("utf-16"),
    "broken": b"soft_arm: {ros__parameters: [",
    "list": b"[1, 2]",
    "without ros__parameters": b"soft_arm: {scene: x}",
    "nested": b"soft_arm: {ros__parameters: {poses: {a: 3}}}",
    "alias": b"soft_arm: {ros__parameters: {poses: &a 3, b: *a}}",
    "tag": b"soft_arm: {ros__parameters: {poses: !!python/object/apply:os.system ['x']}}",
    "two documents": b"soft_arm: {ros__parameters: {poses: 3}}\n---\na: 3\n",
    "mixed list": b"soft_arm: {ros__parameters: {poses: [1, a]}}",
    "null": b"soft_arm: {ros__parameters: {poses: null}}",
    "number for a name": b"5: {ros__parameters: {poses: 3}}",
    "escape": b'"a\\n\\e[31m": {ros__parameters: {poses: 3}}',
    "two million bytes": b"#" * 2_000_000,
}


@pytest.fixture(scope="module")
def ask():
    """Ask a process to run a program with some words; give its exit code and what it said."""
    command = [sys.executable, Path(__file__).with_name("refusing.py")]
    with Popen(command, stdin=PIPE, stdout=PIPE, text=True, env=child_environment()) as process:

        def ask(words, program="simulate"):
            print(json.dumps([program, list(words)]), file=process.stdin, flush=True)
            ready, _, _ = select.select([process.stdout], [], [], 60.0)
            if not ready:
                process.kill()
            assert ready, f"{program} {words}: neither refused nor started within 60 s"
            return json.loads(process.stdout.readline())

        yield ask
        process.stdin.close()
        assert process.wait(60.0) == 0


@pytest.fixture
def refused(ask):
    """Run a program up to where the arm would be made; give the one line that refuses it."""

    def refused(words, program="simulate"):
        code, said = ask(words, program)
        lines = said.splitlines()
        assert code == 2, lines
        assert len(lines) == 1, lines
        assert lines[0].isprintable(), lines
        assert len(lines[0]) < 1200
        return lines[0]

    return refused


@pytest.mark.parametrize("assignment", BAD_PARAMETERS + BAD_OVERRIDES, ids=ascii)
def test_a_parameter_that_cannot_be_used_is_refused_on_one_line(refused, assignment):
    said = refused(["--ros-args", "-p", assignment])
    if assignment in BAD_PARAMETERS:
        assert assignment.partition(":=")[0] in said and "expected" in said


@pytest.mark.parametrize("assignment", BAD_QUALITIES)
def test_a_quality_of_service_that_is_unknown_is_refused_on_one_line(refused, assignment):
    said = refused(["--ros-args", "-p", assignment])
    assert "qos_overrides" in said


@pytest.mark.parametrize("rule", BAD_REMAPS)
def test_a_name_that_ros_does_not_take_is_refused_on_one_line(refused, rule):
    refused(["--ros-args", "-r", rule])


@pytest.mark.parametrize("words", BAD_WORDS, ids=ascii)
def test_a_word_that_means_nothing_is_refused_on_one_line(refused, words):
    refused(words)


@pytest.mark.parametrize("name", BAD_FILES)
def test_a_file_of_parameters_that_cannot_be_used_is_refused_on_one_line(refused, name, tmp_path):
    file = tmp_path / "parameters.yaml"
    file.write_bytes(BAD_FILES[name])
    refused(["--ros-args", "--params-file", str(file)])


@pytest.mark.timeout(20)
@pytest.mark.parametrize("name", ["missing", "folder", "fifo", "/dev/zero", "unreadable"])
def test_what_is_no_readable_file_is_refused_on_one_line(refused, name, tmp_path):
    file = tmp_path / name
    if name == "folder":
        file.mkdir()
    elif name == "fifo":
        os.mkfifo(file)
    elif name == "unreadable":
        file.touch(mode=0)
        if os.access(file, os.R_OK):
            pytest.skip("nothing is unreadable to root")
    refused(["--ros-args", "--params-file", name if name[0] == "/" else str(file)])


def test_a_file_with_names_that_match_slowly_is_looked_through_at_once(tmp_path):
    from soft_sim_ros.node.parameter_files import passed_over

    file = tmp_path / "parameters.yaml"
    file.write_bytes(b"/" + b"**/a/" * 200 + b"x: {ros__parameters: {poses: 3}}")
    (line,) = passed_over(["--params-file", str(file)], "/a" * 100 + "/soft_arm")
    assert len(line) < 1500


def test_of_many_faults_the_first_are_said_and_the_others_counted(ask, tmp_path):
    file = tmp_path / "parameters.yaml"
    names = "".join(f"    p{k}: 1\n" for k in range(5000))
    file.write_text(f"soft_arm:\n  ros__parameters:\n{names}")
    code, said = ask(["--ros-args", "--params-file", str(file)])
    lines = said.splitlines()
    assert code == 2
    assert len(lines) == 21 and "and 4980 more faults" in lines[-1]


@pytest.mark.parametrize(
    "words",
    [
        *(["x", "--rate", rate] for rate in ("nan", "-1", "1e-310", "1e300", "fast", "inf")),
        *(["x", "--delay", delay] for delay in ("nan", "-1", "1e300", "soon")),
        *([], ["x", "y"], ["x", "--ros-args", "-r", "__ns:=bad"], ["/nope\n\x1b[31m"]),
    ],
    ids=ascii,
)
def test_the_replay_refuses_on_one_line_too(refused, words):
    refused(words, "replay")


@pytest.mark.parametrize(
    ("variable", "value"),
    [
        ("ROS_DOMAIN_ID", "abc"),
        ("ROS_DOMAIN_ID", "100000"),
        ("ROS_DOMAIN_ID", "-1"),
        ("ROS_LOG_DIR", "/dev/null/x"),
    ],
)
def test_an_environment_that_ros_cannot_start_in_is_no_traceback(
    monkeypatch, tmp_path, variable, value
):
    monkeypatch.setenv(variable, value)
    program = Program(tmp_path, PROGRAM, "--ros-args", "-p", "scene:=no_such_scene")
    assert program.wait(60.0) == 2
    assert "Traceback" not in program.text
    assert len(program.text.splitlines()) == 1, program.text


def test_parameter_files_are_read_within_the_bounds_of_scene_files(tmp_path):
    from soft_sim_ros.node.parameter_files import passed_over

    def line_of(file):
        begin = time.process_time()
        (line,) = passed_over(["--params-file", str(file)], "/soft_arm")
        assert time.process_time() - begin < 10.0
        return line

    file = tmp_path / "parameters.yaml"
    lines = ["a0: &a0 [x, x]"]
    lines += [f"a{i}: &a{i} [{', '.join([f'*a{i - 1}'] * 20)}]" for i in range(1, 12)]
    odd = ["\n".join(lines), "a: &a {b: *a}", "[" * 10_000, "x: 1\n" * 90_000, "# " + "x" * 2**21]
    for text in odd:
        file.write_text(text)
        assert "cannot be searched for names of nodes" in line_of(file)
    os.mkfifo(tmp_path / "fifo")
    for odd_file in ("/dev/zero", tmp_path / "fifo", tmp_path):
        assert "cannot be searched for names of nodes (UnfitFile)" in line_of(odd_file)
