#!/usr/bin/python3
"""What make.py makes of a small source: python3 tests/mutation/make_test.py"""

import os
import pathlib
import tempfile
import unittest

import make

WITHOUT_SWITCHES = ["-x", "c++", "-std=c++20"]


def mutations_of(text):
    with tempfile.TemporaryDirectory() as folder:
        path = pathlib.Path(folder) / "source.cpp"
        path.write_text(text)
        files = {os.path.realpath(path): "source.cpp"}
        return make.find(path, WITHOUT_SWITCHES, files)["source.cpp"]


def instead_of(text, kind=None):
    """What stands instead of what, in the order of the source."""
    found, _ = mutations_of(text)
    return [(text[each.start:each.end], each.instead) for each in found
            if kind in (None, each.kind)]


class Makes(unittest.TestCase):
    def test_other_relations(self):
        self.assertEqual(instead_of("bool f(int a, int b) { return a < b; }", "relational"),
                         [("a < b", "a <= b")])
        self.assertEqual(instead_of("bool f(int a, int b) { return a == b; }", "relational"),
                         [("a == b", "a != b")])

    def test_other_relations_of_what_has_only_a_three_way_comparison(self):
        text = ("#include <compare>\n"
                "struct S { int x; auto operator<=>(const S&) const = default; };\n"
                "bool f(S a, S b) { return a > b && a != b; }")
        self.assertEqual(instead_of(text, "relational"),
                         [("a > b", "a >= b"), ("a != b", "a == b")])

    def test_other_arithmetic_but_adds_no_texts_otherwise(self):
        self.assertEqual(instead_of("int f(int a, int b) { return a * b; }", "arithmetic"),
                         [("a * b", "a / b")])
        text = "#include <string>\nstd::string f(std::string a) { return a + a; }"
        self.assertEqual(instead_of(text, "arithmetic"), [])

    def test_other_logic_in_each_part(self):
        text = "bool f(bool a, bool b, bool c) { return a && (b || !c); }"
        self.assertEqual(instead_of(text), [("a && (b || !c)", "a || (b || !c)"),
                                            ("b || !c", "b && !c"), ("!c", "static_cast<bool>(c)")])

    def test_other_bits(self):
        self.assertEqual(instead_of("int f(int a, int b) { return (a & b) << b; }", "bit"),
                         [("(a & b) << b", "(a & b) >> b"), ("a & b", "a | b")])

    def test_steps_the_other_way(self):
        self.assertEqual(instead_of("void f(int a) { a += 2; ++a; }", "arithmetic"),
                         [("a += 2", "a -= 2"), ("++a", "--a")])

    def test_numbers_one_higher_and_zero(self):
        self.assertEqual(instead_of("int f() { return 7; }"),
                         [("7", "(7 + decltype(7)(1))"), ("7", "(7 - 7)")])
        self.assertEqual(instead_of("int f() { return 0; }"), [("0", "(0 + decltype(0)(1))")])

    def test_numbers_with_a_unit(self):
        text = ("#include <chrono>\nusing namespace std::chrono_literals;\n"
                "auto f() { return 5ms; }")
        self.assertEqual(instead_of(text), [("5ms", "(5ms + decltype(5ms)(1))"),
                                            ("5ms", "(5ms - 5ms)")])

    def test_the_other_truth(self):
        self.assertEqual(instead_of("bool f() { return true; }"), [("true", "false")])

    def test_statements_that_are_left_out(self):
        text = "void g(int); void f(int a) { if (a > 9) { return; } g(a); a = g == nullptr; }"
        self.assertEqual(instead_of(text, "statement"),
                         [("return;", ""), ("g(a);", ""), ("a = g == nullptr;", "")])

    def test_no_function_without_its_last_return(self):
        text = "int f(int a) { if (a) { return 1; } else { return 2; } }"
        self.assertEqual(instead_of(text, "statement"), [])
        self.assertEqual(instead_of("int f() { return 1; }", "statement"), [])

    def test_no_jump_left_out_that_goes_where_control_goes_anyway(self):
        text = "void f(int a) { switch (a) { case 1: a = 2; break; default: a = 3; break; } }"
        self.assertEqual(instead_of(text, "statement"),
                         [("a = 2;", ""), ("break;", ""), ("a = 3;", "")])
        text = "void f(int a) { while (a > 3) { if (a == 4) { break; } continue; } }"
        self.assertEqual(instead_of(text, "statement"), [("break;", "")])

    def test_no_values_of_members_that_each_source_compiles_for_itself(self):
        self.assertEqual(instead_of("struct S { int x = 3; };"), [])
        self.assertEqual(len(instead_of("struct S { S(); int x = 3; };")), 2)

    def test_conditions_negated(self):
        text = "int f(int a) { return a > 3 ? 1 : 2; }"
        self.assertEqual(instead_of(text, "condition"), [("a > 3", "!(a > 3)")])

    def test_no_negation_that_is_an_other_relation_already(self):
        self.assertEqual(instead_of("int f(int a) { while (a == 3) { --a; } return a; }",
                                    "condition"), [])

    def test_nothing_that_the_compiler_must_know_and_counts_its_numbers(self):
        text = ("constexpr int k = 5 + 6; template <int N> struct A {}; enum class E { a = 3 };"
                "static_assert(k > 3);"
                "int f(int a) { if constexpr (k > 3) { a = static_cast<int>(sizeof(A<3>)); }"
                " switch (a) { case 4: break; } return a; }")
        found, fixed = mutations_of(text)
        self.assertEqual([each.kind for each in found], ["statement"])
        self.assertEqual(fixed, 2)


class Keys(unittest.TestCase):
    TEXT = "int g(int a) { return a + 1; }\nint f(int a) { a = a + 1; a = a + 1; return a; }\n"

    def keys(self, text):
        return [each.key for each in mutations_of(text)[0]]

    def test_tell_mutations_apart(self):
        keys = self.keys(self.TEXT)
        self.assertEqual(len(keys), len(set(keys)))

    def test_stay_where_another_function_changes(self):
        moved = "\n\n// Other words.\n" + self.TEXT.replace("return a + 1;", "return a  +\n 2 + a;")
        kept = [key for key in self.keys(self.TEXT) if key in self.keys(moved)]
        of_f = [each.key for each in mutations_of(self.TEXT)[0] if each.function == "f(int)"]
        self.assertTrue(of_f)
        self.assertTrue(set(of_f) <= set(kept))

    def test_do_not_depend_on_spaces_and_comments(self):
        spaced = self.TEXT.replace("a + 1", "a /* one more */ +  1")
        self.assertEqual(self.keys(self.TEXT), self.keys(spaced))


class Switches(unittest.TestCase):
    def switched(self, text):
        found, _ = mutations_of(text)
        return make.Switched(text, found, {each.key: at for at, each in enumerate(found, 1)}), found

    def test_keep_lines(self):
        text = "int f(int a,\n      int b) {\n    return a +  // both\n           b;\n}\n"
        switched, _ = self.switched(text)
        self.assertEqual(switched.text.count("\n"), text.count("\n"))
        self.assertIn("(::tribus_mutation::mutated(1) ? (a - b) : (a +  // both\n", switched.text)

    def test_are_one_inside_the_other(self):
        switched, _ = self.switched("bool f(bool a, bool b, bool c) { return a && b && c; }")
        self.assertIn("(::tribus_mutation::mutated(1) ? (a && b || c) : "
                      "((::tribus_mutation::mutated(2) ? (a || b) : (a && b)) && c))",
                      switched.text)

    def test_leave_statements_out(self):
        switched, _ = self.switched("void g(); void f() { g(); }")
        self.assertIn("if (!::tribus_mutation::mutated(1)) { g(); }", switched.text)

    def test_do_not_disturb_the_compiler(self):
        switched, _ = self.switched("constexpr int f(int a) { return a + 1; }")
        self.assertIn("mutated_at_run_time(1)", switched.text)

    def test_find_the_one_that_does_not_compile(self):
        switched, found = self.switched("int f(int a) { return a * 3; }")
        column = switched.text.index("a / 3") + 1
        self.assertEqual([each.instead for each in switched.to_blame(1, column)], ["a / 3"])
        self.assertGreater(len(found), 1)


if __name__ == "__main__":
    unittest.main()
