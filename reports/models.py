"""The list of a library's models: what each can be used as, and what keeps it from the rest."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator

from oracles.library import Library
from oracles.models import FORMS
from reports import text

NAME_WIDTH, SIZE_WIDTH = 64, 10
COUNTED = {"hull": "vertices", "solid": "faces", "composite": "parts"}
"""What the size of a form counts."""


def lines(library: Library) -> Iterator[str]:
    """Lines of the list, one by one, since reading takes a while: a model's sizes by form, and below them its defects.

    A form that a model does not have is a dash; what cannot be read at all comes last, then the counts.
    """
    heads = "".join(f"{form:>{SIZE_WIDTH}}" for form in FORMS)
    units = "".join(f"{COUNTED[form]:>{SIZE_WIDTH}}" for form in FORMS)
    yield from (f"{'model':<{NAME_WIDTH}}{heads}", f"{'':<{NAME_WIDTH}}{units}")
    usable: Counter[str] = Counter()
    for model, defects in library.survey():
        usable.update(form for form in FORMS if not defects[form])
        sizes = "".join(f"{'–' if defects[form] else text.count(model.size(form)):>{SIZE_WIDTH}}" for form in FORMS)
        yield f"{text.visible(model.name):<{NAME_WIDTH}}{sizes}"
        if len(said := set(defects.values())) == 1 and "" not in said:  # nothing could be read
            yield f"    {text.visible(said.pop())}"
        else:
            yield from (f"    no {form}: {text.visible(defects[form])}" for form in FORMS if defects[form])
    yield from (f"{text.visible(name)} {text.visible(why)}" for name, why in library.unread.items())
    yield text.visible(library.summary())
    yield ", ".join(f"{text.count(usable[form])} usable as {form}" for form in FORMS)
