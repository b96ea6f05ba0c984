"""Turning by keys over a line to a simulated CAN bus: what is sent, and when, beside what is typed and printed."""
import threading
import unittest

from support import DEMO, PATIENCE, Line, Simulator, Terminal

MOVE, HOLD = b"t1428A4", b"t1428A2"  # left_knee, id 2: to a position, and a speed, which is 0 here
RIGHT = "\033[C"
PRESSES = 40


class Jog(unittest.TestCase):
    def setUp(self):
        sim = Simulator()
        self.addCleanup(sim.close)
        self.moves = 0
        self.at_hold = lambda: None
        self.is_held = threading.Event()
        line = Line(sim.link["legs"], self.passes)
        self.addCleanup(line.close)
        self.jog = Terminal("jog", "left_knee", "--robot", DEMO, "--link", f"legs={line.link}", "--yes")
        self.jog.read_until("deg/s")

    def passes(self, frame):
        """The command waits for each answer: what is done here comes before whatever it does next."""
        self.moves += frame.startswith(MOVE)
        if frame.startswith(HOLD) and not self.is_held.is_set():
            self.at_hold()
            self.is_held.set()
        return True

    def press(self, keys):
        """Until it is told to hold."""
        self.jog.type(keys)
        self.assertTrue(self.is_held.wait(PATIENCE), self.jog.seen)

    def quit(self):
        self.jog.type("q")
        self.assertEqual(self.jog.end(), 0, self.jog.seen)
        self.assertIn("it holds at", self.jog.seen)

    def test_keys_that_come_faster_than_it_turns_are_not_run_one_after_the_other(self):
        self.press(PRESSES * RIGHT)
        self.assertGreater(self.moves, 0)
        self.assertLess(self.moves, PRESSES / 2)  # a step each 0.02 s, for the 0.2 s that follow a press; one for each would be all
        self.quit()

    def test_keys_that_come_while_it_is_brought_to_rest_do_not_set_it_in_motion(self):
        self.at_hold = lambda: self.jog.type(PRESSES * RIGHT)
        self.press(RIGHT)
        moves = self.moves
        self.jog.wait(0.5)  # it comes to rest, and has time to turn
        self.quit()
        self.assertEqual(self.moves, moves)

    def test_it_is_told_to_stop_before_anything_is_printed_at_the_end(self):
        self.press(RIGHT)
        self.jog.wait(0.5)  # at rest
        self.is_held.clear()
        reached, is_read = threading.Event(), threading.Event()

        def wait_for_the_reader():
            reached.set()
            is_read.wait(PATIENCE)
        self.at_hold = wait_for_the_reader
        begin = len(self.jog.seen)
        self.jog.type("q")
        self.assertTrue(reached.wait(PATIENCE))
        self.jog.wait(0.1)  # what was printed before takes a moment through the terminal
        printed = self.jog.seen[begin:]
        is_read.set()
        self.assertEqual(self.jog.end(), 0, self.jog.seen)
        self.assertNotIn("\n", printed)
        self.assertIn("\n", self.jog.seen[begin:])


if __name__ == "__main__":
    unittest.main()
