"""Builds node trees in Blender 3.4 from expressions, and lays their nodes out in columns."""

import bpy

Value = object  # a socket, or the value of a socket to which nothing is linked
SOCKETS = {"color": "NodeSocketColor", "float": "NodeSocketFloat", "share": "NodeSocketFloatFactor"}
SOCKETS |= {"vector": "NodeSocketVector", "geometry": "NodeSocketGeometry"}
COLUMN, ROW = 200, 190


class Graph:
    """A node tree that is being built."""

    def __init__(self, tree: bpy.types.NodeTree) -> None:
        """Begins with a tree without nodes."""
        self.tree = tree
        tree.nodes.clear()
        if tree.name in bpy.data.node_groups:
            self.given = tree.nodes.new("NodeGroupInput").outputs
            self.result = tree.nodes.new("NodeGroupOutput").inputs

    def add_input(
        self, name: str, kind: str, default: Value = None, about: str = "", most: float = 1.0, least: float = 0.0
    ) -> bpy.types.NodeSocket:
        """Adds an input of the group; gives the socket within."""
        made = self.tree.inputs.new(SOCKETS[kind], name)
        made.description = about
        if kind in ("float", "share"):
            made.min_value, made.max_value = least, most
        if default is not None:
            made.default_value = default
        return self.given[name]

    def add_output(self, name: str, kind: str, value: bpy.types.NodeSocket, about: str = "") -> None:
        """Adds an output of the group, and links it."""
        self.tree.outputs.new(SOCKETS[kind], name).description = about
        self.tree.links.new(value, self.result[name])

    def node(self, kind: str, inputs: dict[str | int, Value] | None = None, **members: object) -> bpy.types.Node:
        """Adds a node, sets its members, then links or sets inputs by name or number."""
        made = self.tree.nodes.new(kind)
        for name, value in members.items():
            setattr(made, name, value)
        for name, value in (inputs or {}).items():
            socket = made.inputs[name] if isinstance(name, int) else usable(made.inputs, name)
            self.put(socket, value)
        return made

    def put(self, socket: bpy.types.NodeSocket, value: Value) -> None:
        """Links a socket, or sets its value."""
        if isinstance(value, bpy.types.NodeSocket):
            self.tree.links.new(value, socket)
        else:
            socket.default_value = value

    def math(self, operation: str, *values: Value, **members: object) -> bpy.types.NodeSocket:
        """A number of numbers."""
        return self.node("ShaderNodeMath", dict(enumerate(values)), operation=operation, **members).outputs[0]

    def vector(self, operation: str, *values: Value) -> bpy.types.NodeSocket:
        """A vector of vectors."""
        return self.node("ShaderNodeVectorMath", dict(enumerate(values)), operation=operation).outputs["Vector"]

    def ramp(
        self, value: Value, low: Value, high: Value, label: str = "", kind: str = "LINEAR"
    ) -> bpy.types.NodeSocket:
        """The value brought from between two ends to between 0 and 1."""
        inputs = {"Value": value, "From Min": low, "From Max": high}
        return self.node("ShaderNodeMapRange", inputs, interpolation_type=kind, label=label).outputs["Result"]

    def ramp_to(self, share: Value, low: float, high: float) -> bpy.types.NodeSocket:
        """A share of 0 to 1 brought to between two values."""
        return self.node("ShaderNodeMapRange", {"Value": share, "To Min": low, "To Max": high}).outputs["Result"]

    def mix(self, factor: Value, first: Value, second: Value, label: str = "", blend: str = "") -> bpy.types.NodeSocket:
        """A mix of two numbers; of two colors if blend names how."""
        members = {"data_type": "RGBA", "blend_type": blend} if blend else {"data_type": "FLOAT"}
        made = self.node("ShaderNodeMix", label=label, **members)
        for name, value in (("Factor", factor), ("A", first), ("B", second)):
            self.put(usable(made.inputs, name), value)
        return usable(made.outputs, "Result")

    def noise(self, place: Value, scale: Value, detail: float = 6.0, roughness: float = 0.6) -> bpy.types.NodeSocket:
        """Noise between 0 and 1 that takes the whole range."""
        inputs = {"Vector": place, "Scale": scale, "Detail": detail, "Roughness": roughness}
        return self.ramp(self.node("ShaderNodeTexNoise", inputs).outputs["Fac"], 0.3, 0.7)

    def attribute(self, name: str) -> bpy.types.NodeSocket:
        """A color attribute; as a number the grey of a mask, and 0 where it does not exist."""
        return self.node("ShaderNodeAttribute", attribute_name=name, label=name).outputs["Color"]

    def named(self, name: str, label: str = "") -> bpy.types.NodeSocket:
        """The values of a float attribute of geometry nodes."""
        node = self.node("GeometryNodeInputNamedAttribute", {"Name": name}, data_type="FLOAT", label=label)
        return next(socket for socket in node.outputs if socket.type == "VALUE")

    def compare(self, operation: str, first: Value, second: Value) -> bpy.types.NodeSocket:
        """Returns whether one number is above or below another; for values that do not exist neither is true."""
        return self.node("FunctionNodeCompare", {0: first, 1: second}, data_type="FLOAT", operation=operation).outputs[
            0
        ]

    def finished(self) -> bpy.types.NodeTree:
        """The tree, each node in the column behind those that it needs."""
        columns: dict[bpy.types.Node, int] = {}

        def column(node: bpy.types.Node) -> int:
            if node not in columns:
                before = [link.from_node for socket in node.inputs for link in socket.links]
                columns[node] = max((column(one) + 1 for one in before), default=0)
            return columns[node]

        for node in self.tree.nodes:
            column(node)
        rows: dict[int, float] = {}
        for node in self.tree.nodes:
            rows.setdefault(columns[node], 0.0)
            node.location = (COLUMN * columns[node], rows[columns[node]])
            rows[columns[node]] -= ROW + 22.0 * max(len(node.inputs) - 3, 0)
        return self.tree


def usable(sockets: bpy.types.bpy_prop_collection, name: str) -> bpy.types.NodeSocket:
    """The socket of this name that the node's settings show."""
    return next(item for item in sockets if item.name == name and item.enabled)
