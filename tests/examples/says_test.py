"""A check that cannot fail proves nothing: programs that say something else, or nothing, or end badly, are found."""
import unittest

import says


class Says(unittest.TestCase):
    def found(self, script, said):
        return says.problem(["sh", "-c", script], said)

    def test_what_is_said_is_fine(self):
        self.assertIsNone(self.found("echo 'knee    is at -3.00 deg'; echo; echo 'all of it'", "knee is at <-3.5..-2.5> deg\n  all <...>"))

    def test_a_number_outside_of_its_range_is_found(self):
        for value in ("0.00", "29.0", "-28.65", "nan", "28.65.1"):
            self.assertIn("and not", self.found(f"echo 'elbow is at {value} deg'", "elbow is at <28..28.9> deg"), value)

    def test_every_number_of_a_line_counts(self):
        self.assertIn("and not", self.found("echo '1 V, 9 A'", "<0..2> V, <0..2> A"))

    def test_a_dot_is_a_dot(self):
        self.assertIn("and not", self.found("echo '1x5 V'", "1.5 V"))

    def test_an_exit_code_counts_whatever_is_said(self):
        self.assertIn("it ended with 3", self.found("echo arrived; exit 3", "arrived"))

    def test_a_complaint_counts_whatever_is_said(self):
        self.assertIn("it complains", self.found("echo arrived; echo odd >&2", "arrived"))

    def test_a_line_that_is_missing_or_too_much_is_found(self):
        for said in ("", "arrived\narrived"):
            self.assertIn("lines instead of", self.found("echo arrived", said))


if __name__ == "__main__":
    unittest.main()
