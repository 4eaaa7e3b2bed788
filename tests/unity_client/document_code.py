"""Converts the C# in the package's documents into sources that can be compiled: each ```csharp block of a page becomes a file.

A block that declares a type at its outermost level becomes a file without changes. For any other block the using directives stay at the
top, members become members of a class, and statements become the body of its method. That class inherits the names in
documents/Context.cs, and uses the namespaces that scripts of a game with this package use.
"""

import re

BLOCK = re.compile(r"^```csharp\n(.*?)^```$", re.MULTILINE | re.DOTALL)
USING = re.compile(r"^using ([\w.]+);\n", re.MULTILINE)
FILE = re.compile(r"^(?:namespace|(?:(?:public|internal|sealed|static|abstract|partial|unsafe) )*(?:class|struct|interface|enum)) ", re.MULTILINE)
MEMBERS = re.compile(r"^(?:\[|public |private |protected |internal )", re.MULTILINE)
KNOWN = {"Sweepstake", "Sweepstake.Unity", "System.Collections", "System.Collections.Generic", "UnityEngine"}


def source(name, block, line):
    """Returns the text of a file; compiler errors refer to the page and its line."""
    place = f'#line {line} "{name}"\n'
    if FILE.search(block):
        return place + block
    usings = "".join(f"using {space};\n" for space in sorted(KNOWN | set(USING.findall(block))))
    body = place + USING.sub("\n", block)
    if not MEMBERS.search(block):
        body = f"private void Snippet()\n{{\n{body}}}\n"
    return f"{usings}namespace Sweepstake.Documents\n{{\ninternal sealed class Page : Context\n{{\n{body}}}\n}}\n"


def write(documents, folder):
    """Writes a file for each block below `documents`, each with its own namespace; returns the paths."""
    folder.mkdir(parents=True, exist_ok=True)
    paths = []
    for page in sorted(documents.rglob("*.md")):
        text = page.read_text(encoding="utf-8")
        for match in BLOCK.finditer(text):
            path = folder / f"{page.stem}_{len(paths)}.cs"
            written = source(page.name, match[1], text.count("\n", 0, match.start(1)) + 1)
            path.write_text(written.replace("namespace Sweepstake.Documents\n", f"namespace Sweepstake.Documents.Page{len(paths)}\n"), encoding="utf-8")
            paths.append(path)
    return paths
