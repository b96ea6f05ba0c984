"""A check that cannot fail proves nothing: each kind of mistake in a small tree must be found, and nothing else."""
import pathlib
import tempfile
import unittest

import behaviour

GOOD = {
    "tests/conformance/data/behaviour.md":
        "# Devices\n\n## A. One\n\n### A.1 Bus\n1. DOC starts\n2. GUESS stops\n   later, INF\n\n| a | b |\n\n## B. Two\n"
        "1. DOC waits\n2. DOC shines\n",
    "tests/conformance/data/behaviour_options.txt": "# a comment\nA.1 2 = late, later\n",
    "tests/conformance/data/behaviour_host.txt": "B 2 = only to be seen\n",
    "sinew/family/options.cpp": 'flag("late"),',
    "sinew/sim/options.cpp": 'flag("later"),',
    "sinew/a_test.cpp": 'TEST(Suite, Starts)\n{\n    covers("A.1 1"); // not covers("B 9")\n}\n',
    "tests/system/b_test.py": 'class B:\n    def test_waits(self):\n        covers("B 1")\n',
}


def outcome(changed=None, write=True, **how):
    """What is found in the good tree with some files changed; the table is that of the good tree unless written anew."""
    with tempfile.TemporaryDirectory() as folder:
        root = pathlib.Path(folder)
        for name, text in {**GOOD, **(changed or {})}.items():
            path = root / name
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_text(text)
        if write:
            behaviour.check(root, write=True)
        found, summary = behaviour.check(root, **how)
        return found, summary, (root / behaviour.TABLE).read_text() if write else ""


class Behaviour(unittest.TestCase):
    def test_the_good_tree_is_good(self):
        found, summary, table = outcome(require_all=True)
        self.assertEqual(found, [])
        self.assertIn("4 lines, 0 not covered", summary)
        self.assertIn("| A.1 1 | DOC | starts | `Suite.Starts` |  |", table)
        self.assertIn("| A.1 2 | GUESS, INF | stops later, INF |  | `late`, `later` |", table)
        self.assertIn("| B 1 | DOC | waits | `test_waits` |  |", table)
        self.assertIn("| B 2 | DOC | shines | none: only to be seen |  |", table)

    def refuses(self, expected, name, text, **how):
        found, _, _ = outcome({name: text}, **how)
        self.assertEqual(len(found), 1, found)
        self.assertIn(expected, found[0])

    def test_an_unknown_line_is_found(self):
        self.refuses("no such line", "sinew/b_test.cpp", 'TEST(S, T)\n{\n    covers("A.1 7");\n}\n')

    def test_a_call_outside_a_test_is_found(self):
        self.refuses("outside a test", "sinew/b_test.cpp", 'TEST(S, T)\n{\n}\nvoid helper()\n{\n    covers("B 1");\n}\n')

    def test_an_unknown_option_is_found(self):
        self.refuses("no option 'later'", "sinew/sim/options.cpp", "")

    def test_an_excuse_without_a_reason_is_found(self):
        self.refuses("no reason", "tests/conformance/data/behaviour_host.txt", "B 2 = only to be seen\nA.1 1 =\n")

    def test_a_line_without_a_proof_is_counted_and_on_request_found(self):
        changed = {"tests/system/b_test.py": ""}
        found, summary, table = outcome(changed)
        self.assertEqual(found, [])
        self.assertIn("1 not covered: B 1", summary)
        self.assertIn("| B 1 | DOC | waits | **not covered** |  |", table)
        self.refuses("B 1 has neither", "tests/system/b_test.py", "", require_all=True)

    def test_a_guess_without_an_option_is_counted_and_on_request_found(self):
        options, proof = "tests/conformance/data/behaviour_options.txt", "sinew/a_test.cpp"
        proven = {options: "", proof: GOOD[proof].replace('covers("A.1 1");', 'covers("A.1 1");\n    covers("A.1 2");')}
        found, summary, _ = outcome(proven)
        self.assertEqual(found, [])
        self.assertIn("1 without an option: A.1 2", summary)
        found, _, _ = outcome(proven, require_all=True)
        self.assertEqual(found, ["behaviour.md: A.1 2 has a GUESS, but neither an option nor a reason why not"])

    def test_a_reason_stands_in_for_the_option_of_a_guess_and_of_nothing_else(self):
        options, proof = "tests/conformance/data/behaviour_options.txt", "sinew/a_test.cpp"
        covering = {proof: GOOD[proof].replace('covers("A.1 1");', 'covers("A.1 1");\n    covers("A.1 2");')}
        found, _, table = outcome({options: "A.1 2 = none: there is no other way\n", **covering}, require_all=True)
        self.assertEqual(found, [])
        self.assertIn("| `Suite.Starts` | none: there is no other way |", table)
        for wrong in ("A.1 2 = none:\n", "A.1 2 = late\nB 1 = none: it is so\n"):
            found, _, _ = outcome({options: wrong, **covering})
            self.assertEqual(len(found), 1, found)
            self.assertIn("no guess, or no reason", found[0])

    def test_an_option_is_no_proof_of_what_a_document_says(self):
        options = "A.1 2 = late, later\nB 1 = late\n"
        changed = {"tests/conformance/data/behaviour_options.txt": options, "tests/system/b_test.py": ""}
        self.assertIn("1 not covered: B 1", outcome(changed)[1])

    def test_a_stale_table_is_found(self):
        self.refuses("stale", "docs/reference/behaviour.md", "old\n", write=False)


if __name__ == "__main__":
    unittest.main()
