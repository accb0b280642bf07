"""JSON Schema as this project uses it: whether a value fits, values that do, and values that nearly do."""
import copy
import json
import math
import re

ANNOTATIONS = {"title", "description", "default", "example", "examples", "$comment", "$schema", "$id", "$defs", "format", "contentMediaType"}
CHECKED = {"$ref", "type", "enum", "const", "required", "properties", "additionalProperties", "maxProperties", "items", "minItems", "maxItems",
           "uniqueItems", "minLength", "maxLength", "pattern", "minimum", "maximum", "anyOf", "allOf", "not"}
TYPES = {
    "object": lambda value: isinstance(value, dict),
    "array": lambda value: isinstance(value, list),
    "string": lambda value: isinstance(value, str),
    "boolean": lambda value: isinstance(value, bool),
    "null": lambda value: value is None,
    "number": lambda value: isinstance(value, (int, float)) and not isinstance(value, bool),
    "integer": lambda value: TYPES["number"](value) and math.isfinite(value) and value == int(value),
}


def token(key):
    return str(key).replace("~", "~0").replace("/", "~1")


def find(root, pointer):
    """What stands at a JSON pointer; LookupError where nothing does."""
    value = root
    for part in pointer.split("/")[1:]:
        part = part.replace("~1", "/").replace("~0", "~")
        if isinstance(value, list):
            value = value[int(part) if part.isdigit() else len(value)]
        elif isinstance(value, dict):
            value = value[part]
        else:
            raise LookupError(pointer)
    return value


class Schema:
    """A schema at a place of a document; references lead into the document."""

    def __init__(self, document, node):
        self.document, self.node = document, node

    def at(self, node):
        return Schema(self.document, node)

    def target(self):
        return self.at(find(self.document, self.node["$ref"][1:]))

    def problems(self, value, place=""):
        """Pairs of JSON pointer and what is wrong there."""
        node = self.node
        unknown = set(node) - ANNOTATIONS - CHECKED
        assert not unknown, f"keywords that no reader of ours knows: {unknown}"
        if "$ref" in node:
            yield from self.target().problems(value, place)
        if "type" in node and not TYPES[node["type"]](value):
            yield place, f"is no {node['type']}"
            return
        if "enum" in node and not any(same(value, choice) for choice in node["enum"]):
            yield place, "is none of the choices"
        if "const" in node and not same(value, node["const"]):
            yield place, "is another constant"
        if "anyOf" in node and not any(self.at(choice).accepts(value) for choice in node["anyOf"]):
            yield place, "is nothing of anyOf"
        for part in node.get("allOf", ()):
            yield from self.at(part).problems(value, place)
        if "not" in node and self.at(node["not"]).accepts(value):
            yield place, "is what it may not be"
        if TYPES["number"](value):
            if not node.get("minimum", -math.inf) <= value <= node.get("maximum", math.inf):
                yield place, "is out of range"
        elif isinstance(value, str):
            if not node.get("minLength", 0) <= len(value) <= node.get("maxLength", math.inf):
                yield place, "is too short or too long"
            if "pattern" in node and not re.search(node["pattern"].replace("$", r"\Z"), value):
                yield place, "has another pattern"
        elif isinstance(value, list):
            yield from self.problems_of_list(value, place)
        elif isinstance(value, dict):
            yield from self.problems_of_object(value, place)

    def problems_of_list(self, value, place):
        node = self.node
        if not node.get("minItems", 0) <= len(value) <= node.get("maxItems", math.inf):
            yield place, "has too few or too many items"
        if node.get("uniqueItems") and any(same(a, b) for i, a in enumerate(value) for b in value[:i]):
            yield place, "has an item twice"
        for i, item in enumerate(value):
            yield from self.at(node.get("items", {})).problems(item, f"{place}/{i}")

    def problems_of_object(self, value, place):
        node = self.node
        for name in node.get("required", ()):
            if name not in value:
                yield place, f"lacks {name}"
        if len(value) > node.get("maxProperties", math.inf):
            yield place, "has too many members"
        for name, member in value.items():
            rule = node.get("properties", {}).get(name, node.get("additionalProperties", {}))
            if rule is False:
                yield f"{place}/{token(name)}", "is unknown"
            else:
                yield from self.at(rule).problems(member, f"{place}/{token(name)}")

    def accepts(self, value):
        return next(self.problems(value), None) is None


def same(a, b):
    return isinstance(a, bool) == isinstance(b, bool) and a == b


# --- values that fit --------------------------------------------------------------------------------------------------

NAMES = ["a", "left wheel", "Ünïcödé", "金属", "🙂", "a/b~c", "0", "", " ", "\u202eabc", "x" * 300, "\\\"'<&>", "\u007f", "\uffff", "a\nb"]


class Maker:
    """Values that a schema takes. `texts` gives strings for a schema without choices, by its title; None: any."""

    def __init__(self, chance, texts):
        self.chance, self.texts = chance, texts

    def make(self, schema, depth=0):
        node, chance = schema.node, self.chance
        if "$ref" in node:
            return self.make(schema.at({**schema.target().node, **{key: node[key] for key in ("title",) if key in node}}), depth)
        shown = [*node.get("examples", ()), *([node["default"]] if "default" in node else ())]
        if shown and chance.random() < 0.3:
            return copy.deepcopy(chance.choice(shown))
        if "enum" in node:
            return chance.choice(node["enum"])
        if "anyOf" in node and "type" not in node:
            return self.make(schema.at(chance.choice(node["anyOf"])), depth)
        kind = node.get("type")
        if kind == "object":
            return self.make_object(schema, depth)
        if kind == "array":
            return self.make_list(schema, depth)
        if kind in ("number", "integer"):
            return self.make_number(node)
        if kind == "boolean":
            return chance.random() < 0.5
        if kind == "string":
            return self.make_text(node)
        return chance.choice([None, 1, "a", [], {}])

    def make_number(self, node):
        chance = self.chance
        low, high = node.get("minimum", -1000), node.get("maximum", 1000)
        value = chance.choice([low, high, low + (high - low) * chance.random(), low + (high - low) * chance.random() ** 8,
                               min(high, max(low, chance.choice([0, 1, -1, 0.5, 1e-7, 3])))])
        return min(int(high), max(int(math.ceil(low)), int(value))) if node["type"] == "integer" else value

    def make_text(self, node):
        text = self.texts(node.get("title"))
        if text is None:
            text = self.chance.choice(NAMES)
        text = text[:node.get("maxLength", 1000)].ljust(node.get("minLength", 0), "x")
        return text if "pattern" not in node or re.search(node["pattern"], text) else "a"

    def make_list(self, schema, depth):
        node = schema.node
        low, high = node.get("minItems", 0), min(node.get("maxItems", 4), max(4, node.get("minItems", 0)))
        items = [self.make(schema.at(node.get("items", {})), depth + 1) for _ in range(self.chance.randint(low, high))]
        if node.get("uniqueItems"):
            items = [item for i, item in enumerate(items) if item not in items[:i]]
        return items

    def make_object(self, schema, depth):
        node, chance = schema.node, self.chance
        members = node.get("properties", {})
        required = node.get("required", [])
        assert set(required) <= set(members), required
        share = chance.choice([0, 0.2, 0.2, 0.5, 0.9])
        value = {name: self.make(schema.at(rule), depth + 1) for name, rule in members.items()
                 if name in required or chance.random() < share}
        if isinstance(node.get("additionalProperties"), dict):
            for _ in range(chance.randint(0, 2)):
                value[self.texts("key") or chance.choice(NAMES)] = self.make(schema.at(node["additionalProperties"]), depth + 1)
        for rule in node.get("not", {}).get("anyOf", ()):
            if schema.at(rule).accepts(value):
                del value[chance.choice([name for name in rule["required"] if name not in required])]
        if "anyOf" in node and not any(schema.at(choice).accepts(value) for choice in node["anyOf"]):
            for name in chance.choice(node["anyOf"])["required"]:
                value[name] = self.make(schema.at(members[name]), depth + 1)
        return value


# --- values that nearly do --------------------------------------------------------------------------------------------

STRANGE = [None, True, False, 0, -1, 1e308, -1e308, 5e-324, 2**31, 2**53 + 1, 2**63, 2**64, -2**63, 0.1, "", "0", "NaN", [], {}, [[]], [None], {"": 0},
           [1, 2, 3], "builtin:", "../../etc/passwd", "file:/etc/passwd", "x" * 5000, "\u0001", {"type": "color"}]


def places(value, place=()):
    yield place
    items = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, member in items:
        yield from places(member, (*place, key))


def spoil(value, chance):
    """A copy with one thing changed; it may still fit."""
    root = {"": copy.deepcopy(value)}
    *way, last = ("", *chance.choice(list(places(value))))
    holder = root
    for key in way:
        holder = holder[key]
    what = chance.randrange(6)
    target = holder[last]
    if what == 0 and isinstance(target, dict):
        target[chance.choice(["unknown", "", "Type", "__proto__", "a/b~", "x" * 200, *NAMES])] = chance.choice(STRANGE)
    elif what == 1 and isinstance(target, dict) and target:
        del target[chance.choice(list(target))]
    elif what == 2 and isinstance(target, list):
        target.extend(copy.deepcopy(target) or [chance.choice(STRANGE)])
    elif what == 3 and TYPES["number"](target):
        holder[last] = chance.choice([-target, target * 1000, target + 0.5, str(target), [target]])
    elif what == 4 and isinstance(target, str):
        holder[last] = chance.choice([target.upper(), target + " ", target[:-1], target * 50, "part:" + target, target + "\u0000"])
    else:
        holder[last] = copy.deepcopy(chance.choice(STRANGE))
    return root[""]


# --- texts ------------------------------------------------------------------------------------------------------------


def text_of(value, chance):
    """JSON, now and then with numbers, spaces and escapes that others would write."""
    if chance.random() < 0.5:
        return json.dumps(value, ensure_ascii=chance.random() < 0.5)
    gap = chance.choice(["", " ", "\n\t", "\r\n  "])

    def write(node):
        if isinstance(node, dict):
            return "{" + gap + ",".join(f"{json.dumps(key)}{gap}:{gap}{write(member)}" for key, member in node.items()) + "}"
        if isinstance(node, list):
            return "[" + ",".join(gap + write(member) for member in node) + gap + "]"
        if TYPES["integer"](node) and abs(node) < 2**53 and chance.random() < 0.4:
            return chance.choice(["{}.0", "{}e0", "{}E+00", "{}0e-1"]).format(int(node)) if int(node) else chance.choice(["-0", "0e5", "0.000"])
        return json.dumps(node, ensure_ascii=chance.random() < 0.5)

    return gap + write(value) + gap


def broken_text(text, chance):
    """Not the JSON text of a document, whatever the schema says."""
    what = chance.randrange(9)
    if what == 0:
        return text[:chance.randrange(len(text))]
    if what == 1:
        return text.rstrip() + chance.choice(["x", "{}", ",", "]", "\u0000"])
    if what == 2:
        return '{"strict": ' + chance.choice(["NaN", "Infinity", "-Infinity", "+1", "01", "1.", ".5", "0x10", "1e999", "tru", "'a'", "undefined", "//"]) + "}"
    if what == 3:
        return '{"strict": true, "strict": true}'
    if what == 4:
        return '{"output": {"width": 8, "w\\u0069dth": 8}}'
    if what == 5:
        return chance.choice(['{"a":', "["]) * chance.choice([70, 1000, 100_000])
    if what == 6:
        return "\ufeff{" + text
    if what == 7:
        return '{"scene": {"nodes": [{"mesh": "builtin:sphere", "name": "\\ud800"}]}}'
    return chance.choice(["", " ", "null", "0", '""', "[]", "true"]) if chance.random() < 0.5 else '{"' + "k" * 100_000 + '": 0}'
