"""What a computation is, and how it runs: settings, results, threads, values, colors. Never imports bpy."""
