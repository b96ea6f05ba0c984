"""Runs a program of examples/: it must end well and say what it is there to show. Usage: says.py NAME PROGRAM"""
import re
import subprocess
import sys

# Line by line. <low..high> is a number between two; <...> whatever fits on the line.
SAYS = {
    "01_scan": """
        sam 1 at 1500000 bps: SAM-210EO200
        sam 2 at 1500000 bps: SAM-180EO200
        sam 3 at 1500000 bps: SAM-160EO200
        sam 4 at 1500000 bps: SAM-28
        sam 5 at 1500000 bps: SAM-20
        sam 6 at 1500000 bps: SAM-5""",
    "02_read": """
        shoulder_pitch <-0.1..0.1> deg <23.5..24.5> V <0..20> ms ago
        shoulder_roll <-0.1..0.1> deg <23.5..24.5> V <0..20> ms ago
        elbow <-0.1..0.1> deg <23.5..24.5> V <0..20> ms ago
        wrist_yaw <-0.1..0.1> deg <18.5..19.5> V <0..20> ms ago
        wrist_pitch <-0.1..0.1> deg <18.5..19.5> V <0..20> ms ago
        gripper <-0.1..0.1> deg <10.5..11.5> V <0..20> ms ago
        waist_yaw <-0.1..0.1> deg <0..100> ms ago
        waist_pitch <-0.1..0.1> deg <0..100> ms ago
        neck_yaw <-0.1..0.1> deg <0..100> ms ago
        neck_pitch <-0.1..0.1> deg <0..100> ms ago
        left_hip <-0.1..0.1> deg <24..26> C <23.5..24.5> V <0..100> ms ago
        left_knee <-0.1..0.1> deg <24..26> C <23.5..24.5> V <0..100> ms ago
        left_ankle <-0.1..0.1> deg <24..26> C <23.5..24.5> V <0..100> ms ago
        right_hip <-0.1..0.1> deg <24..26> C <23.5..24.5> V <0..100> ms ago
        right_knee <-0.1..0.1> deg <24..26> C <23.5..24.5> V <0..100> ms ago
        right_ankle <-0.1..0.1> deg <24..26> C <23.5..24.5> V <0..100> ms ago""",
    "03_move": """
        elbow is at <28.4..28.9> deg
        waist_yaw is at <28.4..28.9> deg
        left_knee is at <28.4..28.9> deg""",
    "04_stream_positions": "went <45..46.5> deg far, 0 targets refused",
    "05_torque": """
        no torque: the torque constant is not known; <...>
        <-0.5..0.5> A, <-0.1..0.1> rad/s
        id 2: left_knee: it has come to its limit of 130.00 deg and holds""",
    "06_group": "\n".join([f"motor {id}: encoder <0..65535>" for id in range(1, 7)] + ["6 motors in <0.5..3> ms"]),
    "07_record": "<5000..20000> messages in <...>07_record.mcap",
    # More of P swings further and ends nearer, more of D swings less.
    "08_tune": """
        P 20 D 10: overshoot <0..1> %, ends <-8..-5> deg off
        P 40 D 10: overshoot <2..6> %, ends <-5..-3.5> deg off
        P 80 D 10: overshoot <10..16> %, ends <-3..-1> deg off
        P 80 D 60: overshoot <0..1> %, ends <-3..-1> deg off""",
    "09_motion_program": """
        4 instructions kept
        it moves between <116000..118000> and <154000..156000> by itself""",
    "10_mixed_robot": "\n".join(
        [f"left {name} <190..201> positions a second, the last <0..20> ms ago"
         for name in ("shoulder_pitch", "shoulder_roll", "elbow", "wrist_yaw", "wrist_pitch", "gripper")]
        + [f"waist {name} <120..160> positions a second, the last <0..20> ms ago"
           for name in ("waist_yaw", "waist_pitch", "neck_yaw", "neck_pitch")]
        + [f"legs {side}_{name} <190..201> positions a second, the last <0..20> ms ago"
           for side in ("left", "right") for name in ("hip", "knee", "ankle")]),
    "11_own_loop": "<300..600> cycles; the knee is at <59.5..60.5> deg",
    "12_fault_handling": """
        <2.5..3.2> s stopped: id 1: knee: it has not answered for <0.2..0.4> s; is its cable or its supply off?
        <2.5..4.5> s not enabled: knee of bus legs, <...>: no answer within <...>
        <2.5..4.5> s not enabled: knee of bus legs, <...>: no answer within <...>
        <2.5..4.5> s not enabled: knee of bus legs, <...>: no answer within <...>
        elbow: confirmed
        knee: confirmed""",
    "13_messages": "arrived",
    "14_sequence": """
        elbow is at <57..57.6> deg
        waist_yaw is at <28.4..28.9> deg""",
}


def lines(text):
    return [" ".join(line.split()) for line in text.splitlines() if line.strip()]


def fits(line, said):
    """Whether a line of a program is the one that is expected."""
    texts, holes = re.split(r"<.*?>", said), re.findall(r"<(.*?)>", said)
    pattern = re.escape(texts[0])
    for hole, text in zip(holes, texts[1:]):
        pattern += (".*" if hole == "..." else r"(-?\d+(?:\.\d+)?)") + re.escape(text)
    got = re.fullmatch(pattern, line)
    ranges = [map(float, hole.split("..")) for hole in holes if hole != "..."]
    return got is not None and all(low <= float(value) <= high for value, (low, high) in zip(got.groups(), ranges))


def problem(program, said):
    """What is wrong with a program, as a sentence; None: nothing."""
    done = subprocess.run(program, capture_output=True, text=True, timeout=50)
    if done.returncode != 0:
        return f"it ended with {done.returncode}\n{done.stdout}{done.stderr}"
    if done.stderr:
        return f"it complains: {done.stderr}"
    shown, expected = lines(done.stdout), lines(said)
    for line, want in zip(shown, expected):
        if not fits(line, want):
            return f"it says\n  {line}\nand not\n  {want}"
    if len(shown) != len(expected):
        return f"it says {len(shown)} lines instead of {len(expected)}:\n{done.stdout}"
    return None


if __name__ == "__main__":
    name, program = sys.argv[1:]
    wrong = problem([program], SAYS[name])
    sys.exit(f"{name}: {wrong}" if wrong else 0)
