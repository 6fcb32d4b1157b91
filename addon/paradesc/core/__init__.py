"""Says what a computation is and runs it: settings, results, threads, values, colors. Never imports bpy."""
