"""A small SVG writer: boxes, arrows and text on white."""

from html import escape

INK, SOFT, BLUE, PALE = "#1b1f24", "#57606a", "#0969a8", "#eef4fa"
HEAD = ('<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width} {height}" width="{width}" height="{height}" '
        'font-family="DejaVu Sans, Verdana, sans-serif" font-size="13" role="img">\n<title>{title}</title>\n'
        '<defs><marker id="head" viewBox="0 0 10 10" refX="9" refY="5" markerWidth="7" markerHeight="7" orient="auto-start-reverse">'
        f'<path d="M0 0 L10 5 L0 10 z" fill="{INK}"/></marker></defs>\n<rect width="100%" height="100%" fill="#ffffff"/>\n')


class Drawing:
    def __init__(self, width, height, title):
        self.parts = [HEAD.format(width=width, height=height, title=escape(title))]

    def text(self, x, y, words, anchor="middle", color=INK, size=13, weight="normal"):
        """Lines of text; y is that of the first one's middle."""
        for n, line in enumerate(words.split("\n")):
            self.parts.append(f'<text x="{x}" y="{y + 4 + 16 * n}" text-anchor="{anchor}" fill="{color}" font-size="{size}" font-weight="{weight}">{escape(line)}</text>\n')

    def box(self, x, y, width, height, words, note="", fill=PALE):
        """A box whose middle is (x, y), with a bold name and a note below it."""
        self.parts.append(f'<rect x="{x - width / 2:g}" y="{y - height / 2:g}" width="{width}" height="{height}" rx="8" fill="{fill}" stroke="{BLUE}" stroke-width="1.5"/>\n')
        self.text(x, y - (8 if note else 0), words, weight="bold")
        if note:
            self.text(x, y + 10, note, color=SOFT, size=12)

    def frame(self, x, y, width, height):
        self.parts.append(f'<rect x="{x}" y="{y}" width="{width}" height="{height}" rx="12" fill="none" stroke="{SOFT}" stroke-dasharray="6 4"/>\n')

    def path(self, d, dashed=False, head=True):
        dash = ' stroke-dasharray="5 4"' if dashed else ""
        end = ' marker-end="url(#head)"' if head else ""
        self.parts.append(f'<path d="{d}" fill="none" stroke="{INK}" stroke-width="1.4"{dash}{end}/>\n')

    def whole(self):
        return "".join(self.parts) + "</svg>\n"


class Sequence:
    """A sequence diagram: lifelines at columns, one message below the other."""

    TOP, STEP = 46, 44

    def __init__(self, title, names, columns, rows):
        self.columns, self.row = columns, 0
        self.width, self.height = columns[-1] + 110, self.TOP + 34 + int(self.STEP * rows)
        self.drawing = Drawing(self.width, self.height, title)
        for name, x in zip(names, columns):
            self.drawing.path(f"M{x} {self.TOP} V{self.height - 12}", dashed=True, head=False)
            self.drawing.box(x, 26, 190, 36, name)

    def y(self):
        return self.TOP + 34 + self.STEP * self.row

    def message(self, sender, receiver, words, dashed=False):
        begin, end = self.columns[sender], self.columns[receiver]
        self.drawing.path(f"M{begin} {self.y():g} H{end + (-2 if end > begin else 2)}", dashed)
        self.drawing.text((begin + end) / 2, self.y() - 12, words, size=12)
        self.row += 1

    def note(self, column, words):
        lines = words.split("\n")
        x, height = self.columns[column], 16 * len(lines) + 10
        self.drawing.parts.append(f'<rect x="{x - 100}" y="{self.y() - 20:g}" width="200" height="{height}" fill="#fff8e1" stroke="#b58900"/>\n')
        self.drawing.text(x, self.y() - 20 + 13, words, size=12)
        self.row += 0.36 * len(lines) + 0.55

    def whole(self):
        return self.drawing.whole()
