"""Batches: many scenes run in parallel processes, with their expectations checked."""

from mbproj.studies.batch.run import SceneResult, Task, exit_code, run_batch, scene_paths, tasks

__all__ = ["SceneResult", "Task", "exit_code", "run_batch", "scene_paths", "tasks"]
