"""The fixed text of scripts."""

from __future__ import annotations

HEAD = '''#!/usr/bin/env python3
"""{title}

{story}

    python FILE                       asks {engine}, and judges its answer
    python FILE "distance = 3.0" ...  judges this answer instead

The engine is asked in a process of its own, which may crash, and is ended after {limit} seconds. What is true need not
be believed: this file holds a certificate, and checks it in exact arithmetic with nothing but the standard library.
Exit status: 1 while the answer is wrong, 0 once it is right, 2 if the engine is not installed or the certificate does
not hold.
"""

from __future__ import annotations
'''

PARTS = (
    "1. The engine, called as its users call it",
    "2. The scene, what was answered, and what proves it wrong",
    "3. The exact checker",
    "4. The verdict",
    "5. Long lists of numbers",
)

MAIN = """def main(arguments):
{near}    if arguments == ["--ask"]:
        {ask}
        return 0
{again}    lacking = "" if arguments else missing(NEEDED)
    if lacking:
        print(lacking)
        return 2
    try:
        {check}
    except (Refused, ArithmeticError, LookupError, TypeError, ValueError) as why:
        print(f"the certificate does not hold: {{why}}")
        return 2
{asking}
{judge}"""
ASK_TIMED = """for module, _ in NEEDED:
            import_module(module)
        start = time.process_time()
        ask()
        print("seconds =", time.process_time() - start)"""
NEAR = """    sys.path.append("")  # the engine's module is looked for in the current folder, too
"""
AGAIN = """    if arguments == ["--ask-again"]:
        ask_again()
        return 0
"""

ASK = """    answer, words = (told(arguments, NAMES), "") if arguments else asked(__file__, "--ask", {limit}, NAMES)
    print_answer("{engine}", answer, words, ANSWER)"""
ASK_BOTH = """    first, words = asked(__file__, "--ask", {limit}, NAMES)
    print_answer("{engine}", first, words, FIRST)
    answer, words = (told(arguments, NAMES), "") if arguments else asked(__file__, "--ask-again", {limit}, NAMES)
    print_answer(CHANGE, answer, words, ANSWER)"""

CHECK = "sides = proofs_of(SIDES)"
CHECK_LAWS = "laws_of(MOTIONS[0], RIGHT, MOST)"

JUDGE = """    print_proofs(sides)
    return verdict(answer, wrong_by(answer, ANSWER, sides, HELD), ALLOWED)
"""
JUDGE_CONTRADICTION = """    print_proofs(sides)
    both = (SYMPTOM, AMOUNT) if (first, answer) == (FIRST, ANSWER) else None
    return verdict(answer, wrong_by(answer, ANSWER, sides, HELD) or both, ALLOWED)
"""
JUDGE_IMPACT = """    print_laws(MOTIONS[0], RIGHT)
    return verdict(answer, of_impact(answer, MOTIONS, MOST, SYMPTOM), ALLOWED)
"""

END = """if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
"""
