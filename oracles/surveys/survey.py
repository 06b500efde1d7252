"""What a subject of a survey and its engines have to say of themselves."""

from __future__ import annotations

import importlib.util
from abc import ABC, abstractmethod
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version
from typing import Any, ClassVar, NamedTuple

from oracles.isolation.child import Answerer

REFERENCE = "refimpl"
"""Name of the engine that is this project's own: where it is proven wrong, the reference is."""


@dataclass(frozen=True, eq=False)
class Case:
    """One thing that is asked.

    Attributes
    ----------
    question, regime : str
        Names that the survey explains.
    data
        All that it takes, as plain data of JSON; only the survey knows what is in it.
    """

    question: str
    regime: str
    data: Mapping[str, Any]

    def to_json(self) -> dict[str, Any]:
        """Return it as plain data."""
        return {"question": self.question, "regime": self.regime, "data": dict(self.data)}

    @classmethod
    def from_json(cls, data: Mapping[str, Any]) -> Case:
        """Read it back; what is in it is for the survey to check (`Survey.check`)."""
        return cls(str(data["question"])[:100], str(data["regime"])[:100], dict(data["data"]))


@dataclass(frozen=True)
class Judgement:
    """What is proven of one answer.

    Attributes
    ----------
    amount : float
        By how much the answer is off, at least, in the unit of the question; 0 where nothing is wrong with it.
    words : str
        What is proven, in a sentence.
    proof
        What proves it, as plain data: a certificate, or the exact truth. None where the sentence says it all.
    undecided : bool
        Whether what is known allows both.
    """

    amount: float
    words: str
    proof: Any = None
    undecided: bool = False


class SurveyEngine(ABC):
    """An engine that answers the questions of a survey. Its library is imported where it answers, and nowhere else.

    Attributes
    ----------
    calls : str
        Functions of the library that answer.
    promise : str
        What the library promises, or what it is held to, and why.
    """

    calls: ClassVar[str]
    promise: ClassVar[str]

    def answers(self, question: str) -> bool:
        """Whether it is asked this."""
        del question
        return True

    def tolerance(self, case: Case) -> float:
        """By how much an answer may be off, in the unit of the question."""
        del case
        return 0.0

    @abstractmethod
    def answer(self, case: Case) -> Any:
        """Answer, as plain data; called in a process of its own, which may crash, hang or raise."""


class Library(NamedTuple):
    """Where an engine of a survey comes from."""

    address: str
    """The adapter, as ``module:class``."""
    module: str
    """What has to be installed for it."""
    package: str
    """What installs that."""
    distribution: str = ""
    """What has its version, where that has another name than the module."""

    @property
    def spec(self) -> str:
        """What a child needs to know to be the engine."""
        return f"{self.address} {self.module}"

    def missing(self) -> str:
        """Why it cannot be asked here; empty where it can."""
        if importlib.util.find_spec(self.module) is not None:
            return ""
        return f"needs the module {self.module}, which is not installed: pip install {self.package}"

    def version(self) -> str:
        """Version of what is installed; empty where there is none."""
        try:
            return version(self.distribution or self.module)
        except PackageNotFoundError:
            return ""

    def load(self) -> SurveyEngine:
        """Make the adapter; the library itself is not imported."""
        module, _, attribute = self.address.partition(":")
        made: SurveyEngine = getattr(import_module(module), attribute)()
        return made


class Survey(ABC):
    """A subject.

    Attributes
    ----------
    name, title, about : str
        In a word, as a heading, and in a paragraph: what is asked, and by what an answer is judged.
    questions, regimes : mapping
        Name to a sentence. That of a question says in which unit an answer is off.
    engines : mapping
        Name to where it comes from.
    each : float
        Seconds that one answer may take: many more than it does, as other processes want the processor, too.
    """

    name: ClassVar[str]
    title: ClassVar[str]
    about: ClassVar[str]
    questions: ClassVar[Mapping[str, str]]
    regimes: ClassVar[Mapping[str, str]]
    engines: ClassVar[Mapping[str, Library]]
    each: ClassVar[float] = 10.0

    @abstractmethod
    def cases(self, seed: int) -> Sequence[Case]:
        """Cases of every question and regime, the same for the same seed."""

    @abstractmethod
    def judge(self, case: Case, answer: Any) -> Judgement:
        """Say what is proven of an answer, whoever gave it.

        Raises
        ------
        ValueError, TypeError, LookupError
            For something that is no answer at all.
        """

    @abstractmethod
    def check(self, case: Case) -> None:
        """Raise ValueError, TypeError or LookupError for anything but a case: witnesses are read from files."""

    def size(self, case: Case) -> float:
        """Length that the ledger takes for the size of a case; answers are off by shares of it."""
        del case
        return 1.0

    def special(self, case: Case) -> str:
        """What is special about a case, for the ledger."""
        del case
        return ""

    def simpler(self, case: Case) -> Iterator[Case]:
        """Simpler cases of the same question that may show the same, the simplest first."""
        del case
        return iter(())

    @abstractmethod
    def written(self, case: Case) -> str:
        """Return a case as a person writes it down, in Python where that can be."""


def answerer(spec: str) -> Answerer:
    """What answers in the child: the engine (`Library.spec`), whose library is imported before anything is asked."""
    address, _, module = spec.partition(" ")
    import_module(module)
    engine = Library(address, module, "").load()

    def answer(data: Mapping[str, Any]) -> Any:
        return engine.answer(Case.from_json(data))

    return answer
