"""A report's page as a parser reads it, and names that would break a page that took them as they are."""

from html.parser import HTMLParser

from camid.number_text import SPACE

HOSTILE = {
    "input_column": "<script>document.title = 'run'</script>",
    "output_column": '$x_{1} & "y" </text><img src=x onerror=alert(1)>',
    "recordings": ["<script>document.title = 'run'</script>.csv", "b\x07ell\n.csv"],
    "warnings": ["</li><script>document.title = 'run'</script>"],
    "explanation": "<script>document.title = 'run'</script>",
}


class Page(HTMLParser):
    """Elements, attributes, identifiers of sections and text of a page."""

    def __init__(self, text):
        super().__init__()
        self.tags, self.attributes, self.sections, self.parts = [], [], [], []
        self.feed(text)
        self.close()
        # Style sheet and script are text to the parser, but not to the reader.
        self.text = " ".join(" ".join(self.parts).replace(SPACE, " ").split())

    def handle_starttag(self, tag, attrs):
        self.tags.append(tag)
        self.attributes += attrs
        if tag == "section":
            self.sections.append(dict(attrs)["id"])

    def handle_data(self, data):
        if self.tags and self.tags[-1] not in {"style", "script"}:
            self.parts.append(data)
