# SPDX-License-Identifier: Apache-2.0
"""The C++ as the rules of ARCHITECTURE.md see it: who includes whom, what Run takes, how long files are. Finders return breaches as lines."""
import pathlib
import re

MOST_LINES, MOST_LINES_OF_MAIN = 250, 60
SHARES_HEADERS_OF = {"media": "io"}  # a module that a program loads: it links no library of ours
MAY_BE_IN_HEADERS = re.compile(r"Eigen/\w+|nlohmann/json\.hpp|fmt/format\.h|sys/types\.h|[a-z_]+")
THIRD_PARTY = re.compile(r"\b(?:cv|pcl|ceres|octomap|octomath|OIIO|CLI|Imath)::|\b(?:hid_t|herr_t|RTC\w+|sqlite3)\b")
LIBRARY = re.compile(r"nightmap_library\((?:\w+/)*(\w+) LINK ([^)]*)\)")
LINKS_OF_STAGES = re.compile(r"target_link_libraries\(stage_\$\{stage\} PUBLIC ([^)]*)\)")
RUN = re.compile(r"^[^\n#]*\b(Run[A-Z]\w*)\(((?:[^;{]|\{\})*?)\);", re.MULTILINE)
COMMA_BETWEEN_PARAMETERS = re.compile(r",\s*(?![^<(]*[>)])")
KINDS_IN_ORDER = (r"\w*Options&", "", r"^Progress& progress$", r"^int num_threads$")  # empty: inputs, all others
FILE_PARAMETER = re.compile(r"filesystem::path|string(?:_view)?&? (?:\w*_)?(?:file|path|source|root|folder)s?$|StageContext")
NAME_OF_FILE = re.compile(r'"[^"\n]*\w\.(?:csv|json|h5|tum|txt|pgm|png|jpg|ply|ot|bt|yaml)\b[^"\n]*"')


def ours_of(targets):
    return set(re.findall(r"nightmap_(\w+)", targets))


def reached(names, links):
    while more := set().union(*(links.get(name, set()) for name in names)) - names:
        names = names | more
    return names


def kind_of(parameter):
    return next((kind for kind, pattern in enumerate(KINDS_IN_ORDER) if pattern and re.search(pattern, parameter)), 1)


class Sources:
    def __init__(self, root):
        """Texts are without comments; `below` has of each library those that it links, and what these link."""
        self.texts = {path.relative_to(root): re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8")) for folder in ("pipeline", "stages", "tests")
                      for path in sorted((root / folder).rglob("*")) if path.suffix in (".cc", ".h")}  # fmt: skip
        self.ours = [path for path in self.texts if path.parts[0] != "tests"]
        self.headers = [path for path in self.ours if path.suffix == ".h"]
        self.stages = {path.parent for path in self.ours if path.parts[0] == "stages" and path.name == "main.cc"}
        cmake = [root / "CMakeLists.txt", *(root / "pipeline").glob("*/links.cmake")]
        links = {name: ours_of(targets) for path in cmake for name, targets in LIBRARY.findall(path.read_text(encoding="utf-8"))}
        self.links_of_wing = {path.parent.relative_to(root): ours_of(" ".join(LINKS_OF_STAGES.findall(path.read_text(encoding="utf-8"))))
                              for path in (root / "stages").glob("*/links.cmake")}  # fmt: skip
        self.below = {name: reached(linked, links) for name, linked in links.items()}
        self.included = {path: [pathlib.Path(name) for name in re.findall(r'^#include "((?:pipeline|stages)/[^"]+)"', text, re.MULTILINE)]
                         for path, text in self.texts.items()}  # fmt: skip

    def owner(self, path):
        """Name of the library, or folder of the stage, that a file belongs to."""
        if path.parts[0] == "stages":
            return next((folder for folder in path.parents if folder in self.stages), None)
        return next((folder.name for folder in path.parents if folder.name in {*self.below, *SHARES_HEADERS_OF}), None)

    def may_include(self, owner):
        if owner in self.stages:
            return {owner} | reached(self.links_of_wing.get(owner.parent, set()), self.below)
        shared = SHARES_HEADERS_OF.get(owner, owner)
        return {owner, shared} | self.below.get(shared, set())

    def wrong_includes(self):
        return [f"{path}: {name}" for path in self.ours for name in self.included[path]
                if self.owner(name) not in self.may_include(self.owner(path)) - {None}]  # fmt: skip

    def is_internal(self, header):
        """Whether only .cc files of its own library or stage include it."""
        return all(user.suffix == ".cc" and self.owner(user) == self.owner(header) for user in self.ours if header in self.included[user])

    def third_party_in_headers(self):
        found = {header: [name for name in re.findall(r"^#include <([^>]+)>", self.texts[header], re.MULTILINE) if not MAY_BE_IN_HEADERS.fullmatch(name)]
                 + THIRD_PARTY.findall(self.texts[header]) for header in self.headers}  # fmt: skip
        return [f"{header}: {names[0]}" for header, names in found.items() if names and not self.is_internal(header)]

    def long_files(self):
        """Lines of the files that are too long, by name without .cc; of several with that name the longest."""
        lengths = sorted((text.count("\n"), path.name.removesuffix(".cc")) for path, text in self.texts.items())
        return {name: length for length, name in lengths if length > MOST_LINES}

    def long_mains(self):
        return [str(stage) for stage in sorted(self.stages) if self.texts[stage / "main.cc"].count("\n") > MOST_LINES_OF_MAIN]

    def runs(self):
        """Header, name and parameters of each function Run<Stage>."""
        return [(header, name, COMMA_BETWEEN_PARAMETERS.split(" ".join(parameters.split()))) for header in self.headers
                if header.parts[0] == "stages" for name, parameters in RUN.findall(self.texts[header])]  # fmt: skip

    def runs_out_of_order(self):
        kinds = [(header, name, [kind_of(parameter) for parameter in parameters]) for header, name, parameters in self.runs()]
        return [f"{header}: {name}" for header, name, order in kinds if order != sorted(order)]

    def runs_of_files(self):
        """Runs that take the name of a file, and names of files in the sources that Run is made of."""
        taken = [f"{header}: {name}({parameter})" for header, name, parameters in self.runs() for parameter in parameters if FILE_PARAMETER.search(parameter)]
        made, waiting = set(), [header for header, *_ in self.runs()]
        while waiting:
            path = waiting.pop()
            if path in self.texts and path.parts[0] == "stages" and path not in made:
                made.add(path)
                waiting += [path.with_suffix(".cc"), *self.included[path]]
        return taken + [f"{path}: {name}" for path in sorted(made) for name in NAME_OF_FILE.findall(re.sub("#include[^\n]*", "", self.texts[path]))]
