// Flamenco job type: frames of an animation into a folder of frame files. Frames that are there are kept, so tasks may be
// repeated. Plain ECMAScript 5.

var JOB_TYPE = {
    label: "Paradesc: Frames",
    description: "Compute geometric descriptors of objects, frame by frame",
    settings: [
        {key: "blendfile", type: "string", subtype: "file_path", required: true, visible: "web",
         eval: "bpy.data.filepath", description: "The scene"},
        {key: "frames", type: "string", required: true, eval: "f'{C.scene.frame_start}-{C.scene.frame_end}'",
         evalInfo: {showLinkButton: true, description: "Scene frame range"}, description: "Frames, such as 1-100 or 1-10,20"},
        {key: "chunk_size", type: "int32", default: 10, visible: "submission", description: "Frames a task"},
        {key: "cache", type: "string", subtype: "dir_path", required: true,
         eval: "bpy.path.abspath('//paradesc_cache')", description: "The folder of the frame files, seen by all workers"},
        {key: "descriptors", type: "string", default: "",
         description: "Names between commas; if empty, those of the options, else of the panel"},
        {key: "radius", type: "string", default: "",
         description: "A share of the bounding box's diagonal, or several between commas; if empty, as above"},
        {key: "backend", type: "string", choices: ["cpu", "gpu", "software"], default: "cpu",
         description: "What computes, on all workers alike"},
        {key: "options", type: "string", default: "--scene-settings",
         description: "More options of paradesc animate, such as --object Body"},
        {key: "program", type: "string", default: "{blender} --background --command paradesc", visible: "web",
         description: "What the commands begin with, between spaces"}
    ]
};

function compileJob(job) {
    var settings = job.settings;
    var chunks = frameChunker(settings.frames, settings.chunk_size);
    for (var index = 0; index < chunks.length; index++) {
        var task = author.Task("frames-" + chunks[index], "blender");
        var ranges = chunks[index].split(",");
        for (var range = 0; range < ranges.length; range++) {
            task.addCommand(animate(settings, ranges[range]));
        }
        job.addTask(task);
    }
}

// The command that computes frames from A to B, written A-B.
function animate(settings, frames) {
    var words = settings.program.split(" ").filter(function (word) { return word.length > 0; });
    return author.Command("exec", {
        exe: words[0],
        args: words.slice(1).concat([
            "animate", settings.blendfile, "--frames=" + frames, "--cache", settings.cache,
            "--descriptors", settings.descriptors || "", "--radius", settings.radius || "", "--backend", settings.backend || "cpu",
            "--also", settings.options || "", "--progress", "lines"
        ])
    });
}
