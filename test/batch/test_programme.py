"""Files of commands: what they mean, and what is said about bad ones."""

import numpy as np
import pytest

from soft_sim_ros.batch.programme import ProgrammeError, read_programme

ACTUATORS, SAFE = ("a", "b", "c"), (0.0, 7.0, 0.0)


@pytest.fixture
def read(tmp_path):
    def read_text(text):
        file = tmp_path / "commands.csv"
        file.write_text(text)
        return read_programme(file, ACTUATORS, SAFE)

    return read_text


def test_actuators_come_in_any_order_and_those_left_out_are_safe(read):
    programme = read("time, c, a\n0, 1, 2\n\n# a remark\n0.5, 3, 4\n")
    np.testing.assert_array_equal(programme.time, [0.0, 0.5])
    np.testing.assert_array_equal(programme.efforts, [[2.0, 7.0, 1.0], [4.0, 7.0, 3.0]])


def test_a_row_is_taken_up_at_the_first_step_not_before_its_time(read):
    programme = read("time,a\n0,1\n0.003,1\n0.0040001,1\n0.3,1\n")
    # 0.3 / 0.002 is 149.99999999999997 in floating-point numbers, and means 150
    assert programme.steps(0.002).tolist() == [0, 2, 3, 150]


def test_a_header_alone_is_a_programme_of_nothing(read):
    assert read("time,a\n").efforts.shape == (0, 3)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "header ''"),
        ("t,a\n0,1\n", ":1: header 't,a': expected time,a,b,c"),
        ("time,x\n0,1\n", ":1: unknown actuator 'x': expected time,a,b,c"),
        ("time,a,a\n0,1,2\n", ":1: 'a' is there twice"),
        ("time,a\n0,1\n1\n", ":3: 1 values: expected 2"),
        ("time,a\n0,one\n", ":2: a = 'one': expected a finite number"),
        ("time,a\n0,nan\n", ":2: a = 'nan': expected a finite number"),
        ("time,a\n-1,0\n", ":2: time = -1 s: expected a time of at least 0 s"),
        ("time,a\n2,0\n1,0\n", ":3: time = 1 s: expected a time of at least 2 s"),
    ],
)
def test_what_is_wrong_is_named_with_its_line(read, text, message):
    with pytest.raises(ProgrammeError) as caught:
        read(text)
    assert message in str(caught.value)
