"""Does Blender read an image's layers as they were written? benches/peer/blender.py IMAGE.exr

Needs `pip install bpy numpy OpenEXR` (bpy 5.0.1 is for Python 3.11). Each layer goes through the compositor's node `Image`, each matte of a
Cryptomatte through the node `Cryptomatte` by its name. Prints the largest difference from what the OpenEXR library reads, and fails
if there is any.
"""

import json
import os
import sys
import tempfile

import bpy
import numpy
import OpenEXR

# How the node calls a layer's channels, in order.
ORDERS = ["RGBA", "XYZ", "UV", "Z", "Y", "V"]


def composited(path, size, node_of):
    """The image behind the socket that `node_of` makes of the file."""
    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene = bpy.context.scene
    tree = bpy.data.node_groups.new("layers", "CompositorNodeTree")
    tree.interface.new_socket("Image", in_out="OUTPUT", socket_type="NodeSocketColor")
    scene.compositing_node_group = tree
    socket = node_of(tree, bpy.data.images.load(path))
    tree.links.new(socket, tree.nodes.new("NodeGroupOutput").inputs[0])
    camera = bpy.data.objects.new("camera", bpy.data.cameras.new("camera"))
    scene.collection.objects.link(camera)
    scene.camera = camera
    scene.render.engine = "CYCLES"
    scene.cycles.samples = 1
    scene.render.resolution_y, scene.render.resolution_x = size
    scene.render.image_settings.file_format = "OPEN_EXR"
    scene.render.image_settings.color_depth = "32"
    scene.view_settings.view_transform = "Raw"
    scene.render.filepath = os.path.join(tempfile.mkdtemp(), "composited.exr")
    bpy.ops.render.render(write_still=True)
    found = OpenEXR.File(scene.render.filepath, separate_channels=True).channels()
    return [found[channel].pixels for channel in "RGB"]


def layer_of(name):
    def node_of(tree, image):
        node = tree.nodes.new("CompositorNodeImage")
        node.image = image
        return node.outputs[name]

    return node_of


def matte_of(kind, name):
    def node_of(tree, image):
        node = tree.nodes.new("CompositorNodeCryptomatteV2")
        node.source, node.image, node.layer_name, node.matte_id = "IMAGE", image, kind, name
        return node.outputs["Matte"]

    return node_of


def cover(channels, kind, number):
    """The part of each pixel that the thing of this number covers, in a Cryptomatte."""
    ranks = [(f"{kind}0{level}.{a}", f"{kind}0{level}.{b}") for level in range(3) for a, b in ("RG", "BA")]
    return sum(numpy.where(channels[a] == number, channels[b], 0) for a, b in ranks)


def main(path):
    file = OpenEXR.File(path, separate_channels=True)
    channels = {name: channel.pixels for name, channel in file.channels().items()}
    header = file.header()
    size = channels["R"].shape
    worst = 0

    def compare(name, found, expected):
        nonlocal worst
        difference = max(numpy.abs(a - b).max() for a, b in zip(found, expected))
        worst = max(worst, difference)
        print(f"{name:32} {difference:9.2g} of {max(numpy.abs(b).max() for b in expected):9.4g}")

    layers = {name.rpartition(".")[0] for name in channels} - {""}
    layers = {name for name in layers if not name.startswith("Crypto")}
    compare("(colors)", composited(path, size, layer_of("Combined")), [channels[c] for c in "RGB"])
    if "A" in channels:
        compare("A", composited(path, size, layer_of("Alpha")), [channels["A"]])
    for layer in sorted(layers):
        order = next(order for order in ORDERS if f"{layer}.{order[0]}" in channels)
        expected = [channels[f"{layer}.{c}"] for c in order[:3] if f"{layer}.{c}" in channels]
        compare(layer, composited(path, size, layer_of(layer)), expected)
    for key in sorted(header):
        if not (key.startswith("cryptomatte/") and key.endswith("/name")):
            continue
        kind = header[key]
        manifest = json.loads(header[key.removesuffix("name") + "manifest"])
        for name, number in manifest.items():
            number = numpy.frombuffer(bytes.fromhex(number)[::-1], dtype=numpy.float32)[0]
            expected = cover(channels, kind, number)
            compare(f"{kind} {name}", composited(path, size, matte_of(kind, name)), [expected])
    sys.exit(worst > 0)


main(os.path.abspath(sys.argv[1]))
