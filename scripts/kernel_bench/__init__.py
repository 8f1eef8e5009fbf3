"""What bench_kernel.py measures and how: scenes, runs without recording, memory."""
