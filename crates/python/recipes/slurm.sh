#!/bin/sh
# Numbered frames as a SLURM array: each of its tasks renders a share of them.
#
#   sbatch --array=1-100 crates/python/recipes/slurm.sh scene.glb 0..10000 /shared/out/%06d.exr --samples 16
#
# Arguments are the scene, the frames, the pictures, and options of `umbrage render`. The folder must be there. The same
# line again, with the whole array, goes on where tasks were ended: how many tasks there are says which frames each has.
#SBATCH --job-name=umbrage
#SBATCH --array=1-8
#SBATCH --cpus-per-task=4
#SBATCH --requeue
set -eu

scene=$1 frames=$2 pictures=$3
shift 3
exec umbrage render "$scene" --frames "$frames" -o "$pictures" --resume \
    --shard "$SLURM_ARRAY_TASK_ID/$SLURM_ARRAY_TASK_COUNT" --threads "${SLURM_CPUS_PER_TASK:-1}" "$@"
