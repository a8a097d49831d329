#if !defined _WIN32
#define _POSIX_C_SOURCE 200809L /* clock_gettime */
#endif

#include "thread.h"

#include <stdlib.h>

#if defined _WIN32
#include <windows.h>
#else
#include <pthread.h>
#include <sched.h>
#include <time.h>
#include <unistd.h>
#endif

struct Thread {
    void (*body)(void *);
    void *argument;
#if defined _WIN32
    HANDLE handle;
#else
    pthread_t handle;
#endif
};

#if defined _WIN32

static DWORD WINAPI enter(void *argument) {
    Thread *thread = argument;
    thread->body(thread->argument);
    return 0;
}

static bool begin(Thread *thread) {
    thread->handle = CreateThread(NULL, 0, enter, thread, 0, NULL);
    return thread->handle != NULL;
}

void thread_join(Thread *thread) {
    WaitForSingleObject(thread->handle, INFINITE);
    CloseHandle(thread->handle);
    free(thread);
}

struct Monitor {
    SRWLOCK lock;
    CONDITION_VARIABLE condition;
};

Monitor *monitor_new(void) {
    Monitor *monitor = malloc(sizeof *monitor);
    if (monitor == NULL) return NULL;
    InitializeSRWLock(&monitor->lock);
    InitializeConditionVariable(&monitor->condition);
    return monitor;
}

void monitor_free(Monitor *monitor) {
    free(monitor);
}

void monitor_lock(Monitor *monitor) {
    AcquireSRWLockExclusive(&monitor->lock);
}

void monitor_unlock(Monitor *monitor) {
    ReleaseSRWLockExclusive(&monitor->lock);
}

void monitor_sleep(Monitor *monitor) {
    SleepConditionVariableSRW(&monitor->condition, &monitor->lock, INFINITE, 0);
}

void monitor_wake(Monitor *monitor) {
    WakeAllConditionVariable(&monitor->condition);
}

#else

static void *enter(void *argument) {
    Thread *thread = argument;
    thread->body(thread->argument);
    return NULL;
}

static bool begin(Thread *thread) {
    return pthread_create(&thread->handle, NULL, enter, thread) == 0;
}

void thread_join(Thread *thread) {
    pthread_join(thread->handle, NULL);
    free(thread);
}

struct Monitor {
    pthread_mutex_t lock;
    pthread_cond_t condition;
};

Monitor *monitor_new(void) {
    Monitor *monitor = malloc(sizeof *monitor);
    if (monitor == NULL) return NULL;
    if (pthread_mutex_init(&monitor->lock, NULL) != 0) {
        free(monitor);
        return NULL;
    }
    if (pthread_cond_init(&monitor->condition, NULL) != 0) {
        pthread_mutex_destroy(&monitor->lock);
        free(monitor);
        return NULL;
    }
    return monitor;
}

void monitor_free(Monitor *monitor) {
    if (monitor == NULL) return;
    pthread_cond_destroy(&monitor->condition);
    pthread_mutex_destroy(&monitor->lock);
    free(monitor);
}

void monitor_lock(Monitor *monitor) {
    pthread_mutex_lock(&monitor->lock);
}

void monitor_unlock(Monitor *monitor) {
    pthread_mutex_unlock(&monitor->lock);
}

void monitor_sleep(Monitor *monitor) {
    pthread_cond_wait(&monitor->condition, &monitor->lock);
}

void monitor_wake(Monitor *monitor) {
    pthread_cond_broadcast(&monitor->condition);
}

#endif

Thread *thread_start(void (*body)(void *), void *argument) {
    Thread *thread = malloc(sizeof *thread);
    if (thread == NULL) return NULL;
    thread->body = body;
    thread->argument = argument;
    if (begin(thread)) return thread;
    free(thread);
    return NULL;
}

void thread_pause(void) {
#if defined __x86_64__ || defined __i386__
    __builtin_ia32_pause();
#elif defined __aarch64__
    __asm__ volatile("yield");
#endif
}

void thread_yield(void) {
#if defined _WIN32
    SwitchToThread();
#else
    sched_yield();
#endif
}

unsigned long thread_process(void) {
#if defined _WIN32
    return GetCurrentProcessId();
#else
    return (unsigned long)getpid();
#endif
}

double thread_clock(void) {
#if defined _WIN32
    LARGE_INTEGER ticks, ticks_per_second;
    QueryPerformanceCounter(&ticks);
    QueryPerformanceFrequency(&ticks_per_second);
    return (double)ticks.QuadPart / (double)ticks_per_second.QuadPart;
#else
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
#endif
}
