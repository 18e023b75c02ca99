"""Laws that no catalogue has, put into recordings that were measured: is their mechanism named, and nothing else?"""
