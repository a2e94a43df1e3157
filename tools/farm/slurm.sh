#!/bin/sh
#SBATCH --job-name=gobo
#SBATCH --cpus-per-task=2
#SBATCH --mem=4G
#SBATCH --requeue
#SBATCH --open-mode=append
#SBATCH --output=gobo.%a.log
# Frames of a scene by a Slurm array: each of its tasks renders every Nth frame and leaves those that are whole.
#   job=$(sbatch --parsable --array=0-15 tools/farm/slurm.sh SCENE OUT 0..240 [gobo's options]...)
#   sbatch --dependency=afterany:$job --wrap "gobo verify OUT"
# The same again renders what is missing. Slurm copies this script: SCENE and OUT are paths from where it was submitted.
set -eu
scene=$1 out=$2 frames=$3
shift 3
shard=$((SLURM_ARRAY_TASK_ID - SLURM_ARRAY_TASK_MIN))
exec "${GOBO:-gobo}" render "$scene" -o "$out" --frames "$frames" \
	--shard "$shard/$SLURM_ARRAY_TASK_COUNT" --skip-existing "$@"
