
# 75: interrupted, to be continued. 74: a file could not be read or written, or a process that Slurm has lost sight of
# still writes the shard; ten times, perhaps on another node.
# The numbers of array and task name this task alone: SLURM_JOB_ID may be the number of the whole array.
task=${SLURM_ARRAY_JOB_ID}_$SLURM_ARRAY_TASK_ID
if [[ $canceled == no ]]; then
    if ((code == 75)) || ((code == 74 && ${SLURM_RESTART_COUNT:-0} < 10)); then
        echo "task $task ended with code $code: back into the queue"
        scontrol requeue "$task"
    fi
fi
